// Plate with a circular inclusion, pulled to the left and right (Goodier 1933). Units: mm.
//
//   +---------------+ side/2
//   |     plate     |
//   |     .---.     |
//  left  ( (o) )   right      o: inclusion; ring: between it and radius `ring`, for the material points
//   |     '---'     |
//   |               |
//   +---------------+
//   -side/2         side/2

DefineConstant[
  radius  = {10,  Min 1, Name "Geometry/Radius of the inclusion [mm]"},
  ring    = {25,  Name "Geometry/Outer radius of the ring [mm]"},
  side    = {800, Name "Geometry/Side of the plate [mm]"},
  fine    = {2.5, Name "Mesh/Element size at the inclusion [mm]"},
  element = {50,  Name "Mesh/Element size far away [mm]"},
  order   = {2,   Name "Mesh/Order", Choices{1, 2}}
];

If (radius >= ring || ring >= side / 2)
  Error("radius %g mm, ring %g mm and half the side, %g mm, must grow in this order", radius, ring, side / 2);
  Abort;
EndIf

// ---- Inclusion and ring: four quarters each, so that the axes meet the inclusion in nodes.
Point(1) = {0, 0, 0};
r() = {radius, ring};
For i In {0:1}
  Point(10 + 10 * i) = {r(i), 0, 0};
  Point(11 + 10 * i) = {0, r(i), 0};
  Point(12 + 10 * i) = {-r(i), 0, 0};
  Point(13 + 10 * i) = {0, -r(i), 0};
  For q In {0:3}
    Circle(10 + 10 * i + q) = {10 + 10 * i + q, 1, 10 + 10 * i + (q + 1) % 4};
  EndFor
  Curve Loop(10 + 10 * i) = {10 + 10 * i : 13 + 10 * i};
EndFor

// ---- The plate's outline, with the middles of its sides as points to hold it by.
half = side / 2;
Point(30) = {half, 0, 0};      Point(31) = {half, half, 0};
Point(32) = {0, half, 0};      Point(33) = {-half, half, 0};
Point(34) = {-half, 0, 0};     Point(35) = {-half, -half, 0};
Point(36) = {0, -half, 0};     Point(37) = {half, -half, 0};
For k In {0:7}
  Line(30 + k) = {30 + k, 30 + (k + 1) % 8};
EndFor
Curve Loop(30) = {30:37};

Plane Surface(1) = {10};          // inclusion
Plane Surface(2) = {20, 10};      // ring
Plane Surface(3) = {30, 20};      // plate
Recombine Surface {1, 2, 3};

MeshSize {1, 10:13} = fine;
MeshSize {20:23} = 2 * fine;
MeshSize {30:37} = element;

Physical Surface("inclusion") = {1};
Physical Surface("ring") = {2};
Physical Surface("plate") = {3};
Physical Curve("right") = {30, 37};
Physical Curve("left") = {33, 34};
Physical Point("middle_of_left") = {34};
Physical Point("middle_of_right") = {30};
Physical Point("middle_of_top") = {32};
Physical Point("middle_of_bottom") = {36};

Mesh.ElementOrder = order;
Mesh.SecondOrderIncomplete = 1;
