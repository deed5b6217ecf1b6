// Square plate with a central crack at an angle, pulled up and down. Units: mm.
//
//            top
//   +---------------+ side/2
//   |     plate     |
//   |  +---------+  | band/2
//   |  |    /    |  |     band: square, for the material points; the crack is a curve of its own
//   |  |   /     |  |
//   |  +---------+  |
//   |               |
//   +---------------+
//         bottom

DefineConstant[
  side    = {120, Name "Geometry/Side of the plate [mm]"},
  band    = {40,  Name "Geometry/Side of the band [mm]"},
  crack   = {20,  Name "Geometry/Length 2a of the crack [mm]"},
  angle   = {45,  Name "Geometry/Angle of the crack to x [degrees]"},
  fine    = {4,   Name "Mesh/Element size at the band [mm]"},
  element = {10,  Name "Mesh/Element size at the sides [mm]"},
  order   = {2,   Name "Mesh/Order", Choices{1, 2}}
];

If (crack >= band || band >= side)
  Error("crack %g mm, band %g mm and side %g mm must grow in this order", crack, band, side);
  Abort;
EndIf

// ---- Two squares about the origin: band and plate.
half() = {band / 2, side / 2};
size() = {fine, element};
For i In {0:1}
  h = half(i);
  Point(10 + 10 * i) = {-h, -h, 0, size(i)};
  Point(11 + 10 * i) = {h, -h, 0, size(i)};
  Point(12 + 10 * i) = {h, h, 0, size(i)};
  Point(13 + 10 * i) = {-h, h, 0, size(i)};
  For k In {0:3}
    Line(10 + 10 * i + k) = {10 + 10 * i + k, 10 + 10 * i + (k + 1) % 4};
  EndFor
  Curve Loop(10 + 10 * i) = {10 + 10 * i : 13 + 10 * i};
EndFor
Plane Surface(1) = {10};
Plane Surface(2) = {20, 10};
Recombine Surface {1, 2};

// The crack cuts bonds, the mesh need not know it.
reach_x = crack / 2 * Cos(angle * Pi / 180);
reach_y = crack / 2 * Sin(angle * Pi / 180);
Point(1) = {-reach_x, -reach_y, 0};
Point(2) = {reach_x, reach_y, 0};
Line(1) = {1, 2};
Transfinite Curve {1} = 2;

Physical Surface("band") = {1};
Physical Surface("plate") = {2};
Physical Curve("crack") = {1};
Physical Curve("top") = {22};
Physical Curve("bottom") = {20};
Physical Point("corner") = {20};

Mesh.ElementOrder = order;
Mesh.SecondOrderIncomplete = 1;
