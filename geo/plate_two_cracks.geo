// Square plate with two cracks at / and \, mirror images of each other, pulled at top and bottom:
// Qian et al. (2021), section 4.3 and fig. 9. Units: mm.
//
//        top
//   +-----------+ side
//   |   grip    |
//   +-----------+ side/2 + band/2
//   |           |
//   |   /   \   |   band; the cracks' centres at mid-height, inner tips apart by `gap`
//   |           |
//   +-----------+ side/2 - band/2
//   |   grip    |
//   +-----------+
//       bottom

DefineConstant[
  element = {2,  Name "Mesh/Element size [mm]"},
  order   = {2,  Name "Mesh/Order", Choices{1, 2}},
  crack   = {10, Name "Geometry/Crack length [mm]"},
  gap     = {10, Name "Geometry/Between the inner tips [mm]"},
  band    = {30, Name "Geometry/Band height [mm]"}
];

side = 50;
columns = Round(side / element);

y() = {0, (side - band) / 2, (side + band) / 2, side};
For i In {0:3}
  Point(10 + i) = {0, y(i), 0};
  Point(20 + i) = {side, y(i), 0};
  Line(30 + i) = {10 + i, 20 + i};
  Transfinite Curve {30 + i} = columns + 1;
EndFor
For i In {0:2}
  rows = Round((y(i + 1) - y(i)) / element);
  Line(40 + i) = {10 + i, 11 + i};
  Line(50 + i) = {20 + i, 21 + i};
  Transfinite Curve {40 + i, 50 + i} = rows + 1;
  Curve Loop(60 + i) = {30 + i, 50 + i, -(31 + i), -(40 + i)};
  Plane Surface(70 + i) = {60 + i};
  Transfinite Surface {70 + i};
  Recombine Surface {70 + i};
EndFor

// The cracks are curves of their own, at 45 degrees: they cut bonds, the mesh need not know them.
// The inner tips are the upper ones, level with each other.
reach = crack / Sqrt(2);
For i In {0:1}
  inward = 1 - 2 * i;
  inner = side / 2 - inward * gap / 2;
  Point(1 + 2 * i) = {inner - inward * reach, (side - reach) / 2, 0};
  Point(2 + 2 * i) = {inner, (side + reach) / 2, 0};
  Line(1 + i) = {1 + 2 * i, 2 + 2 * i};
  Transfinite Curve {1 + i} = 2;
EndFor

Physical Surface("grips") = {70, 72};
Physical Surface("band") = {71};
Physical Curve("bottom") = {30};
Physical Curve("top") = {33};
Physical Curve("cracks") = {1, 2};

Mesh.ElementOrder = order;
Mesh.SecondOrderIncomplete = 1;
