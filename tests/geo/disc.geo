// A disc of radius 15 in a plate of 100 x 60: an interface that no lattice follows.
SetFactory("OpenCASCADE");
Rectangle(1) = {0, 0, 0, 100, 60};
Disk(2) = {50, 30, 0, 15};
BooleanFragments{ Surface{1}; Delete; }{ Surface{2}; Delete; }
Physical Surface("disc") = {2};
Physical Surface("plate") = {3};
left() = Curve In BoundingBox{-1, -1, -1, 1, 61, 1};
right() = Curve In BoundingBox{99, -1, -1, 101, 61, 1};
Physical Curve("left") = {left()};
Physical Curve("right") = {right()};
Physical Point("corner") = {Point In BoundingBox{-1, -1, -1, 1, 1, 1}};
Mesh.MeshSizeMin = 4;
Mesh.MeshSizeMax = 4;
Mesh.RecombineAll = 1;
Mesh.ElementOrder = 2;
Mesh.SecondOrderIncomplete = 1;
