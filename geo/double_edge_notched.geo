// Square plate with two notches, one from each side at mid-height, in the frames of Nooru-Mohamed's
// shear-and-tension machine (Delft, 1992), as slits. Units: mm.
//
//            pulled
//         +----------+ side
//  pushed |  upper   |
//         +----------+ side/2 + band/2
//         |==      ==|   band, with the notches in its middle
//         +----------+ side/2 - band/2
//         |  lower   | frame (with the lower side)
//         +----------+
//            frame

DefineConstant[
  element = {10, Name "Mesh/Element size [mm]"},
  order   = {2,  Name "Mesh/Order", Choices{1, 2}},
  notch   = {25, Name "Geometry/Notch length [mm]"},
  band    = {120, Name "Geometry/Band height [mm]"}
];

side = 200;
columns = Round(side / element);

// Levels: the lower side, the band with the notches at half its height, the upper side.
y() = {0, (side - band) / 2, side / 2, (side + band) / 2, side};
For i In {0:4}
  Point(10 + i) = {0, y(i), 0};
  Point(20 + i) = {side, y(i), 0};
  Line(30 + i) = {10 + i, 20 + i};
  Transfinite Curve {30 + i} = columns + 1;
EndFor
For i In {0:3}
  rows = Round((y(i + 1) - y(i)) / element);
  Line(40 + i) = {10 + i, 11 + i};
  Line(50 + i) = {20 + i, 21 + i};
  Transfinite Curve {40 + i, 50 + i} = rows + 1;
  Curve Loop(60 + i) = {30 + i, 50 + i, -(31 + i), -(40 + i)};
  Plane Surface(70 + i) = {60 + i};
  Transfinite Surface {70 + i};
  Recombine Surface {70 + i};
EndFor

// The notches are curves of their own: they cut bonds, the mesh need not know them.
For i In {0:1}
  inward = 1 - 2 * i;
  Point(1 + 2 * i) = {i * side, side / 2, 0};
  Point(2 + 2 * i) = {i * side + inward * notch, side / 2, 0};
  Line(1 + i) = {1 + 2 * i, 2 + 2 * i};
  Transfinite Curve {1 + i} = 2;
EndFor

Physical Surface("grips") = {70, 73};
Physical Surface("band") = {71, 72};
Physical Curve("frame") = {30, 50, 51};
Physical Curve("pushed") = {42, 43};
Physical Curve("pulled") = {34};
Physical Curve("notches") = {1, 2};

Mesh.ElementOrder = order;
Mesh.SecondOrderIncomplete = 1;
