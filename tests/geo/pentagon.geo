// A pentagon, turned by 11 degrees, in a plate of 60 x 60.
SetFactory("OpenCASCADE");
DefineConstant[ order = 2, quads = 0 ];
Rectangle(1) = {0, 0, 0, 60, 60};
For k In {0:4}
  Point(100 + k) = {30 + 16 * Cos(0.192 + 2 * Pi * k / 5), 30 + 16 * Sin(0.192 + 2 * Pi * k / 5), 0};
EndFor
For k In {0:3}
  Line(100 + k) = {100 + k, 101 + k};
EndFor
Line(104) = {104, 100};
Curve Loop(100) = {100:104};
Plane Surface(2) = {100};
BooleanFragments{ Surface{1}; Delete; }{ Surface{2}; Delete; }
Physical Surface("disc") = {2};
Physical Surface("plate") = {3};
Mesh.MeshSizeMin = 3.3;
Mesh.MeshSizeMax = 3.3;
Mesh.RecombineAll = quads;
Mesh.ElementOrder = order;
Mesh.SecondOrderIncomplete = 1;
