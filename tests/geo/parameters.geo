// One square per way in which a parameter can be written; its side is the parameter's value.
DefineConstant[
  plain = 1,
  listed = {2},
  labelled = {3, Name "Parameters/Labelled side", Min 0, Max 100},
  name = "plate",
  label = {"second", Name "Parameters/Label"}
];
If (!Exists(tested))
  tested = 4;
EndIf
fixed = DefineNumber[ 5, Name "Parameters/Fixed" ];
side() = {plain, listed, labelled, tested, fixed};
For i In {0:4}
  p = newp;
  Point(p) = {200 * i, 0, 0};
  Point(p + 1) = {200 * i + side(i), 0, 0};
  Point(p + 2) = {200 * i + side(i), side(i), 0};
  Point(p + 3) = {200 * i, side(i), 0};
  Line(p) = {p, p + 1};
  Line(p + 1) = {p + 1, p + 2};
  Line(p + 2) = {p + 2, p + 3};
  Line(p + 3) = {p + 3, p};
  Transfinite Curve {p:p + 3} = 2;
  Curve Loop(p) = {p:p + 3};
  Plane Surface(i + 1) = {p};
  Transfinite Surface {i + 1};
EndFor
Physical Surface(Str(name)) = {1};
Physical Surface(Str(label)) = {2};
Physical Surface("labelled") = {3};
Physical Surface("tested") = {4};
Physical Surface("fixed") = {5};
