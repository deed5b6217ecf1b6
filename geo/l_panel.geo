// L-shaped panel of Winkler (2001): 500 × 500 mm, legs 250 mm wide, pushed up 30 mm from the end of the
// horizontal leg. Units: mm.
//
//   0,500 +------------------------+ 500,500
//         |         panel          |
//  top  - +----------------+       |
//         |      band      |       |
//         |          +-----+---+---+ 500,250
//         |          |        load ^
//  base - +----------+
//         |  panel   |
//     0,0 +----------+ 250,0
//            foot
//
// The band holds the inner corner, where the crack begins, and the way to the left edge.

DefineConstant[
  element = {20,  Name "Mesh/Element size [mm]"},
  order   = {2,   Name "Mesh/Order", Choices{1, 2}},
  base    = {210, Name "Geometry/Band from y [mm]"},
  top     = {410, Name "Geometry/Band to y [mm]"},
  right   = {310, Name "Geometry/Band to x [mm]"}
];

Point(1) = {0, 0, 0};       Point(2) = {250, 0, 0};     Point(3) = {250, base, 0};
Point(4) = {250, 250, 0};   Point(5) = {right, 250, 0}; Point(6) = {470, 250, 0};
Point(7) = {500, 250, 0};   Point(8) = {500, 500, 0};   Point(9) = {0, 500, 0};
Point(10) = {0, top, 0};    Point(11) = {0, base, 0};   Point(12) = {right, top, 0};

Line(1) = {1, 2};   Line(2) = {2, 3};   Line(3) = {3, 4};    Line(4) = {4, 5};
Line(5) = {5, 6};   Line(6) = {6, 7};   Line(7) = {7, 8};    Line(8) = {8, 9};
Line(9) = {9, 10};  Line(10) = {10, 11}; Line(11) = {11, 1};
Line(12) = {11, 3}; Line(13) = {5, 12}; Line(14) = {12, 10};

Curve Loop(1) = {1, 2, -12, 11};                   // lower leg
Curve Loop(2) = {12, 3, 4, 13, 14, 10};            // band
Curve Loop(3) = {5, 6, 7, 8, 9, -14, -13};         // the rest
Plane Surface(1) = {1};
Plane Surface(2) = {2};
Plane Surface(3) = {3};
Recombine Surface {1, 2, 3};
Mesh.MeshSizeMin = element;
Mesh.MeshSizeMax = element;

Physical Surface("panel") = {1, 3};
Physical Surface("band") = {2};
Physical Curve("foot") = {1};
Physical Point("load") = {6};

Mesh.Algorithm = 8;
Mesh.ElementOrder = order;
Mesh.SecondOrderIncomplete = 1;
