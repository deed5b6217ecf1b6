// Two unit squares; groups that overlap, have no name, or are drawn clockwise.
Point(1) = {0, 0, 0};
Point(2) = {1, 0, 0};
Point(3) = {2, 0, 0};
Point(4) = {0, 1, 0};
Point(5) = {1, 1, 0};
Point(6) = {2, 1, 0};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {4, 5};
Line(4) = {5, 6};
Line(5) = {1, 4};
Line(6) = {2, 5};
Line(7) = {3, 6};
Curve Loop(1) = {1, 6, -3, -5};
Curve Loop(2) = {6, 4, -7, -2};  // clockwise
Plane Surface(1) = {1};
Plane Surface(2) = {2};
Transfinite Curve {1:7} = 4;
Transfinite Surface {1, 2};
Recombine Surface {1, 2};
Physical Surface("all") = {1, 2};
Physical Surface("second") = {2};
Physical Surface(17) = {1};
Physical Curve(3) = {1, 2};
Mesh.ElementOrder = 2;
Mesh.SecondOrderIncomplete = 1;

// Meshed, but in no group: left out, its centre too.
Point(7) = {4, 0, 0};
Point(8) = {5, 0, 0};
Point(9) = {4, 1, 0};
Circle(8) = {8, 7, 9};
