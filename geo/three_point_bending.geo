// Notched beam in three-point bending: a sharp crack from below in the middle. Units: mm.
//
//                      load
//   +-------------------+-------------------+ width
//   |      beam      |     |      beam      |
//   |                |band |                |       the crack, in the middle of the band, is a curve of
//   |                |  |  |                |       its own from y = 0 to y = crack
//   +--+-------------+--+--+-------------+--+ 0
//   -support                           support
//
// Above the band a strip of the beam, `cap` high, takes the load, so that it acts on an element node.

DefineConstant[
  width    = {50,  Name "Geometry/Height W of the beam [mm]"},
  crack    = {25,  Name "Geometry/Crack length a [mm]"},
  span     = {200, Name "Geometry/Span S between the supports [mm]"},
  overhang = {10,  Name "Geometry/Beam beyond each support [mm]"},
  band     = {40,  Name "Geometry/Width of the band [mm]"},
  cap      = {5,   Name "Geometry/Elements above the band [mm]"},
  element  = {5,   Name "Mesh/Element size [mm]"},
  order    = {2,   Name "Mesh/Order", Choices{1, 2}}
];

If (crack <= 0 || crack >= width - cap)
  Error("the crack, %g mm, must end within the band, which is %g mm high", crack, width - cap);
  Abort;
EndIf

// ---- A grid of columns and two rows; the supports and the load are corners of it.
x() = {-span / 2 - overhang, -span / 2, -band / 2, 0, band / 2, span / 2, span / 2 + overhang};
y() = {0, width - cap, width};
For i In {0:6}
  For j In {0:2}
    Point(100 + 10 * i + j) = {x(i), y(j), 0};
  EndFor
  For j In {0:1}
    Line(200 + 10 * i + j) = {100 + 10 * i + j, 101 + 10 * i + j};
    Transfinite Curve {200 + 10 * i + j} = Ceil((y(j + 1) - y(j)) / element) + 1;
  EndFor
EndFor
beam() = {};
band_surfaces() = {};
For i In {0:5}
  For j In {0:2}
    Line(300 + 10 * i + j) = {100 + 10 * i + j, 110 + 10 * i + j};
    Transfinite Curve {300 + 10 * i + j} = Ceil((x(i + 1) - x(i)) / element) + 1;
  EndFor
  For j In {0:1}
    s = 400 + 10 * i + j;
    Curve Loop(s) = {300 + 10 * i + j, 210 + 10 * i + j, -(301 + 10 * i + j), -(200 + 10 * i + j)};
    Plane Surface(s) = {s};
    Transfinite Surface {s};
    Recombine Surface {s};
    If (j == 0 && (i == 2 || i == 3))
      band_surfaces() += {s};
    Else
      beam() += {s};
    EndIf
  EndFor
EndFor

// The crack cuts bonds, the mesh need not know it.
Point(1) = {0, 0, 0};
Point(2) = {0, crack, 0};
Line(1) = {1, 2};
Transfinite Curve {1} = 2;

Physical Surface("beam") = {beam()};
Physical Surface("band") = {band_surfaces()};
Physical Curve("crack") = {1};
Physical Point("left_support") = {110};
Physical Point("right_support") = {150};
Physical Point("load") = {132};

Mesh.ElementOrder = order;
Mesh.SecondOrderIncomplete = 1;
