// A structured square of 10 mm with a crack: a curve of its own, which bounds no surface.
// (Line{} In Surface{} would be ignored silently in a transfinite surface.)
DefineConstant[ order = 2 ];
Point(1) = {0, 0, 0};
Point(2) = {10, 0, 0};
Point(3) = {10, 10, 0};
Point(4) = {0, 10, 0};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};
Transfinite Curve {1, 2, 3, 4} = 5;
Transfinite Surface {1};
Recombine Surface {1};
Physical Surface("plate") = {1};

Point(5) = {3, 4, 0};
Point(6) = {5, 5, 0};
Point(7) = {7, 8, 0};
Line(5) = {5, 6};
Line(6) = {6, 7};
Transfinite Curve {5, 6} = 3;
Physical Curve("crack") = {5, 6};
Physical Point("crack tip") = {7};
Mesh.ElementOrder = order;
Mesh.SecondOrderIncomplete = 1;
