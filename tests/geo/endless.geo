// A loop that does not end in any time worth waiting for.
Printf("the loop begins");
For i In {1:1e15}
  a = i;
EndFor
