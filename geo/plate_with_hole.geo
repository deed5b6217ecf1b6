// Plate with a circular hole, pulled to the left and right (Kirsch 1898). Units: mm.
//
//        top
//   +---------------+ side
//   |     plate     |
//   |     .---.     |
//  left  ( (o) )   right      ring: between hole and radius `ring`, for the material points
//   |     '---'     |
//   |               |
//   +---------------+
//   -side/2         side/2
//
// The hole's centre is the origin. With side = 80 hole the plate is as good as endless: what its size adds
// to the displacement at the hole's edge is 0.2 %.

DefineConstant[
  hole    = {10,  Min 1, Name "Geometry/Radius of the hole [mm]"},
  ring    = {30,  Name "Geometry/Outer radius of the ring [mm]"},
  side    = {800, Name "Geometry/Side of the plate [mm]"},
  fine    = {4,   Name "Mesh/Element size at the ring [mm]"},
  element = {50,  Name "Mesh/Element size far away [mm]"},
  order   = {2,   Name "Mesh/Order", Choices{1, 2}}
];

If (hole >= ring || ring >= side / 2)
  Error("hole %g mm, ring %g mm and half the side, %g mm, must grow in this order", hole, ring, side / 2);
  Abort;
EndIf

// ---- Hole and ring: four quarters each, so that the axes meet the hole in points of the geometry.
Point(1) = {0, 0, 0};
radius() = {hole, ring};
For i In {0:1}
  Point(10 + 10 * i) = {radius(i), 0, 0};
  Point(11 + 10 * i) = {0, radius(i), 0};
  Point(12 + 10 * i) = {-radius(i), 0, 0};
  Point(13 + 10 * i) = {0, -radius(i), 0};
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

Plane Surface(1) = {20, 10};      // ring
Plane Surface(2) = {30, 20};      // plate
Recombine Surface {1, 2};

MeshSize {10:13, 20:23} = fine;
MeshSize {30:37} = element;

Physical Surface("ring") = {1};
Physical Surface("plate") = {2};
Physical Curve("hole") = {10:13};
Physical Curve("right") = {30, 37};
Physical Curve("left") = {33, 34};
Physical Point("middle_of_left") = {34};
Physical Point("middle_of_right") = {30};
Physical Point("middle_of_top") = {32};
Physical Point("middle_of_bottom") = {36};

Mesh.ElementOrder = order;
Mesh.SecondOrderIncomplete = 1;
