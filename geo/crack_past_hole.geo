// Plate with an edge crack and a hole above the crack's path, pulled up and down. Units: mm.
//
//               top
//   +-------------------------+ height/2
//   |          plate          |
//   +-------------------------+ above
//   |           ( )   band    |     hole: centre at (hole_x, hole_y); hole = 0: none
//   +----                     | 0   the crack, from the left side, is a curve of its own
//   |crack                    |
//   +-------------------------+ -below
//   |          plate          |
//   +-------------------------+ -height/2
//   0        bottom         width

DefineConstant[
  width   = {120, Name "Geometry/Width [mm]"},
  height  = {120, Name "Geometry/Height [mm]"},
  below   = {15,  Name "Geometry/Band below the crack [mm]"},
  above   = {36,  Name "Geometry/Band above the crack [mm]"},
  crack   = {30,  Name "Geometry/Length of the crack [mm]"},
  hole    = {10,  Min 0, Name "Geometry/Radius of the hole [mm]"},
  hole_x  = {60,  Name "Geometry/Hole at x [mm]"},
  hole_y  = {22,  Name "Geometry/Hole at y [mm]"},
  element = {6,   Name "Mesh/Element size [mm]"},
  order   = {2,   Name "Mesh/Order", Choices{1, 2}}
];

If (hole > 0 && (hole_y - hole <= -below || hole_y + hole >= above))
  Error("the hole, radius %g mm about y = %g mm, must lie within the band, y from %g to %g mm", hole, hole_y, -below, above);
  Abort;
EndIf

// ---- Three rectangles, one above the other.
y() = {-height / 2, -below, above, height / 2};
For i In {0:3}
  Point(10 + i) = {0, y(i), 0};
  Point(20 + i) = {width, y(i), 0};
  Line(30 + i) = {10 + i, 20 + i};
EndFor
For i In {0:2}
  Line(40 + i) = {10 + i, 11 + i};
  Line(50 + i) = {20 + i, 21 + i};
  Curve Loop(60 + i) = {30 + i, 50 + i, -(31 + i), -(40 + i)};
EndFor

// ---- The hole in the middle one.
If (hole > 0)
  Point(1) = {hole_x, hole_y, 0};
  For q In {0:3}
    Point(2 + q) = {hole_x + hole * Cos(q * Pi / 2), hole_y + hole * Sin(q * Pi / 2), 0};
  EndFor
  For q In {0:3}
    Circle(2 + q) = {2 + q, 1, 2 + (q + 1) % 4};
  EndFor
  Curve Loop(2) = {2:5};
  Plane Surface(71) = {61, 2};
Else
  Plane Surface(71) = {61};
EndIf
Plane Surface(70) = {60};
Plane Surface(72) = {62};
Recombine Surface {70:72};
Mesh.MeshSizeMin = element;
Mesh.MeshSizeMax = element;

// The crack cuts bonds, the mesh need not know it.
Point(6) = {0, 0, 0};
Point(7) = {crack, 0, 0};
Line(1) = {6, 7};
Transfinite Curve {1} = 2;

Physical Surface("plate") = {70, 72};
Physical Surface("band") = {71};
Physical Curve("crack") = {1};
Physical Curve("top") = {33};
Physical Curve("bottom") = {30};
Physical Point("corner") = {20};

Mesh.ElementOrder = order;
Mesh.SecondOrderIncomplete = 1;
