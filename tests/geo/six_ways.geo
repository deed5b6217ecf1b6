// A strip with a peridynamic band in its middle and a crack that comes from below; turned, mirrored, moved.
DefineConstant[ turn = 0, mirror = 1, x0 = 0, y0 = 0, structured = 1, height = 41, h = 6 ];
xs[] = {0, 30, 70, 100, 0, 30, 70, 100, 48, 51};
ys[] = {0, 0, 0, 0, height, height, height, height, -1, 15.3};
For i In {0:9}
  x = x0 + mirror * xs[i];
  y = y0 + ys[i];
  Point(i + 1) = {x * Cos(turn) - y * Sin(turn), x * Sin(turn) + y * Cos(turn), 0, h};
EndFor
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4};
Line(4) = {5, 6}; Line(5) = {6, 7}; Line(6) = {7, 8};
Line(7) = {1, 5}; Line(8) = {2, 6}; Line(9) = {3, 7}; Line(10) = {4, 8};
Line(11) = {9, 10};
Curve Loop(1) = {1, 8, -4, -7}; Plane Surface(1) = {1};
Curve Loop(2) = {2, 9, -5, -8}; Plane Surface(2) = {2};
Curve Loop(3) = {3, 10, -6, -9}; Plane Surface(3) = {3};
If (structured)
  Transfinite Curve{1, 3, 4, 6} = 6;
  Transfinite Curve{2, 5} = 8;
  Transfinite Curve{7, 8, 9, 10} = 8;
  Transfinite Surface{1, 2, 3};
EndIf
Recombine Surface{1, 2, 3};
Mesh.ElementOrder = 2;
Mesh.SecondOrderIncomplete = 1;
Physical Surface("left") = {1};
Physical Surface("band") = {2};
Physical Surface("right") = {3};
Physical Curve("clamp") = {7};
Physical Curve("grip") = {10};
Physical Curve("crack") = {11};
Physical Point("corner") = {1};
