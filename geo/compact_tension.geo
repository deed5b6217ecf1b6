// Compact tension specimen with the proportions of ASTM E399, pulled by two soft straps. Units: mm.
//
//           +--+ upper grip
//           |  | strap
//      +----+--+--------------------+ 0.6 width
//      |           arms             |
//      |         +------------------+ band/2
//      +---------+                  |
//        notch   +--crack--         |   band
//      +---------+                  |
//      |         +------------------+ -band/2
//      |           arms             |
//      +----+--+--------------------+
//           |  |
//           +--+ lower grip
//   -width/4  0  notch_end        width
//
// x is measured from the load line, where the straps pull. The notch is a slot in the finite elements;
// from its end on the crack cuts bonds.

DefineConstant[
  width       = {50,  Name "Geometry/Width W from the load line [mm]"},
  crack       = {25,  Name "Geometry/Crack length a from the load line [mm]"},
  notch_end   = {15,  Name "Geometry/Notch ends at x [mm]"},
  notch       = {2,   Name "Geometry/Notch width [mm]"},
  band        = {12.5,  Name "Geometry/Band height [mm]"},
  strap       = {6,   Name "Geometry/Strap width [mm]"},
  strap_length = {40, Name "Geometry/Strap length [mm]"},
  element     = {4,   Name "Mesh/Element size [mm]"},
  order       = {2,   Name "Mesh/Order", Choices{1, 2}}
];

If (crack <= notch_end || crack >= width)
  Error("the crack's tip at x = %g mm must lie between the notch's end, %g mm, and the width, %g mm",
        crack, notch_end, width);
  Abort;
EndIf
If (notch >= band)
  Error("the notch, %g mm, must be lower than the band, %g mm", notch, band);
  Abort;
EndIf

height = 1.2 * width;
x() = {-width / 4, -strap / 2, strap / 2, notch_end, width};
y() = {-height / 2 - strap_length, -height / 2, -band / 2, -notch / 2,
       notch / 2, band / 2, height / 2, height / 2 + strap_length};

// ---- A grid of rectangles, of which only those of the specimen are made.
For j In {0:7}
  For i In {0:4}
    Point(100 + 10 * i + j) = {x(i), y(j), 0};
  EndFor
EndFor
arms() = {};
straps() = {};
band_surfaces() = {};
For j In {0:6}
  For i In {0:3}
    is_strap = (j == 0 || j == 6);
    is_notch = (j == 3 && i < 3);
    is_band = (j > 1 && j < 5 && i == 3);
    If ((is_strap && i == 1) || (!is_strap && !is_notch))
      corner = 100 + 10 * i + j;
      // Sides that a neighbour has made already are used again.
      If (!Exists(bottom~{i}~{j}))
        bottom~{i}~{j} = newc;
        Line(bottom~{i}~{j}) = {corner, corner + 10};
      EndIf
      If (!Exists(left~{i}~{j}))
        left~{i}~{j} = newc;
        Line(left~{i}~{j}) = {corner, corner + 1};
      EndIf
      bottom~{i}~{j + 1} = newc;
      Line(bottom~{i}~{j + 1}) = {corner + 1, corner + 11};
      left~{i + 1}~{j} = newc;
      Line(left~{i + 1}~{j}) = {corner + 10, corner + 11};
      columns = Ceil((x(i + 1) - x(i)) / element);
      rows = Ceil((y(j + 1) - y(j)) / element);
      Transfinite Curve {bottom~{i}~{j}, bottom~{i}~{j + 1}} = columns + 1;
      Transfinite Curve {left~{i}~{j}, left~{i + 1}~{j}} = rows + 1;
      surface = news;
      Curve Loop(surface) = {bottom~{i}~{j}, left~{i + 1}~{j}, -bottom~{i}~{j + 1}, -left~{i}~{j}};
      Plane Surface(surface) = {surface};
      Transfinite Surface {surface};
      Recombine Surface {surface};
      If (is_strap)
        straps() += {surface};
      ElseIf (is_band)
        band_surfaces() += {surface};
      Else
        arms() += {surface};
      EndIf
    EndIf
  EndFor
EndFor

// The crack is a curve of its own: it cuts bonds, the mesh need not know it.
Point(1) = {notch_end, 0, 0};
Point(2) = {crack, 0, 0};
Line(1000) = {1, 2};
Transfinite Curve {1000} = 2;

Physical Surface("arms") = {arms()};
Physical Surface("straps") = {straps()};
Physical Surface("band") = {band_surfaces()};
Physical Curve("lower_grip") = {bottom~{1}~{0}};
Physical Curve("upper_grip") = {bottom~{1}~{7}};
Physical Curve("crack") = {1000};

Mesh.ElementOrder = order;
Mesh.SecondOrderIncomplete = 1;
