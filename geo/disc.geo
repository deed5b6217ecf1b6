// Brazilian disc: pressed between two short arcs, with or without a crack in its middle. Units: mm.
//
//            top: arc of 2 `half_angle`
//          .-===-.
//        /  rim    \        rim:  elements
//       |  .-----.  |       core: disc of radius `core`, for the material points
//       | ( core  ) |       the crack, along y, is a curve of its own; crack = 0: none
//       |  '-----'  |
//        \         /
//          '-===-'
//           bottom

DefineConstant[
  radius     = {50, Name "Geometry/Radius R of the disc [mm]"},
  core       = {25, Name "Geometry/Radius of the core [mm]"},
  crack      = {0,  Min 0, Name "Geometry/Half the crack's length, a [mm]"},
  half_angle = {5,  Name "Geometry/Half the angle of a loaded arc [degrees]"},
  element    = {5,  Name "Mesh/Element size [mm]"},
  fine       = {2,  Name "Mesh/Element size at the loaded arcs [mm]"},
  order      = {2,  Name "Mesh/Order", Choices{1, 2}}
];

If (crack >= core || core >= radius)
  Error("crack %g mm, core %g mm and radius %g mm must grow in this order", crack, core, radius);
  Abort;
EndIf

Point(1) = {0, 0, 0};
For q In {0:3}
  angle = q * Pi / 2;
  Point(10 + q) = {core * Cos(angle), core * Sin(angle), 0};
EndFor
For q In {0:3}
  Circle(10 + q) = {10 + q, 1, 10 + (q + 1) % 4};
EndFor
Curve Loop(10) = {10:13};

// ---- The rim: right, ends of the upper arc with its middle, left, the same below.
arc = half_angle * Pi / 180;
a() = {0, Pi / 2 - arc, Pi / 2, Pi / 2 + arc, Pi, 3 * Pi / 2 - arc, 3 * Pi / 2, 3 * Pi / 2 + arc};
For k In {0:7}
  Point(20 + k) = {radius * Cos(a(k)), radius * Sin(a(k)), 0};
EndFor
For k In {0:7}
  Circle(20 + k) = {20 + k, 1, 20 + (k + 1) % 8};
EndFor
Curve Loop(20) = {20:27};

Plane Surface(1) = {10};
Plane Surface(2) = {20, 10};
Recombine Surface {1, 2};
MeshSize {10:13, 20, 24} = element;
MeshSize {21:23, 25:27} = fine;

Physical Surface("core") = {1};
Physical Surface("rim") = {2};
Physical Curve("top") = {21, 22};
Physical Curve("bottom") = {25, 26};
Physical Point("middle_of_top") = {22};
Physical Point("middle_of_bottom") = {26};
Physical Point("right") = {20};
Physical Point("left") = {24};

If (crack > 0)
  Point(2) = {0, -crack, 0};
  Point(3) = {0, crack, 0};
  Line(1) = {2, 3};
  Transfinite Curve {1} = 2;
  Physical Curve("crack") = {1};
EndIf

Mesh.ElementOrder = order;
Mesh.SecondOrderIncomplete = 1;
