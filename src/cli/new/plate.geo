// NAME.geo: a square plate with a crack in its left edge, pulled at top and bottom. Units: mm.
//
//            top
//     +----------------+  side
//     |     grips      |  finite elements
//     +----------------+
//     |----- crack     |  band: material points, where the crack may run
//     +----------------+
//     |     grips      |
//     +----------------+  0
//          bottom
//
// Open this file in Gmsh to look at it and to change it. What counts for peristitch are the Physical
// groups at the end: the pipeline, NAME.yaml, calls them by name.

// Numbers that the pipeline may set: geometry: { parameters: { crack: 15 } }, or on the command line
// --set geometry.parameters.crack=15.
DefineConstant[
  element = {2.5, Name "Mesh/Element size [mm]"},
  crack   = {12,  Name "Geometry/Crack length [mm]"},
  band    = {20,  Name "Geometry/Band height [mm]"}
];

side = 50;
y() = {0, (side - band) / 2, (side + band) / 2, side};

// Three rectangles on top of each other, meshed by a grid of quadrilaterals.
columns = Round(side / element);
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

// The crack is a curve of its own: it cuts the bonds that it meets, and the mesh need not follow it.
Point(1) = {0, side / 2, 0};
Point(2) = {crack, side / 2, 0};
Line(1) = {1, 2};

Physical Surface("grips") = {70, 72};
Physical Surface("band") = {71};
Physical Curve("bottom") = {30};
Physical Curve("top") = {33};
Physical Curve("crack") = {1};

// Eight-node quadrilaterals.
Mesh.ElementOrder = 2;
Mesh.SecondOrderIncomplete = 1;
