//! peristitch: quasi-static fracture in two dimensions by a hybrid of peridynamics and finite elements.
//!
//! # The paper on one page
//!
//! Qian, Fan, Shen & Xia (2021). Equation numbers are the paper's.
//!
//! **Peridynamics** where cracks are to appear. Material points x_i, x_j no farther apart than the
//! horizon δ interact by a bond ξ = x_j − x_i whose force is along it and proportional to its stretch
//! s, eqs. (1)–(4). Its micromodulus c(ξ) = c0 g(ξ/δ), eq. (8), has the kernel
//! g = (1 − (ξ/δ)²)², eq. (9), and equal strain energies give c0 = 315 E / (8π δ³) in plane stress,
//! eq. (10). On a lattice, a bond becomes an axial spring, eqs. (16)–(19):
//!
//! ```text
//! K_ij = k n⊗n,   k = c(ξ) A_i A_j h_t / ξ
//! ```
//!
//! **Finite elements** elsewhere: isoparametric, with eight nodes, eqs. (11)–(15).
//!
//! ```text
//! K U = R,   K = Σ C_eᵀ k C_e,   k = ∫ Bᵀ D B h_t dA
//! ```
//!
//! **Coupling**: a truss from every element node on the interface to every material point within δ,
//! eq. (20), with the same k and an area A_FE for the node. All of it adds up to one K, solved
//! directly, without artificial damping.
//!
//! **Fracture**: a bond breaks at its critical stretch, eqs. (5) and (6), and damage is the share of a
//! point's bonds that are broken, eq. (7). K U = R is solved again with what is left.
//!
//! docs/method.md has every formula as implemented, and where the paper leaves something open.
//!
//! # Modules in the order of the method
//!
//! | | |
//! |---|---|
//! | [`gmsh`] | `.geo` → mesh, in a child process |
//! | [`meshio`] | meshes of other programs → mesh, in a child process |
//! | [`mesh`], [`geometry`] | cells and physical groups; polygons |
//! | [`material`] | E, ν → D |
//! | [`peridynamics`] | eqs. (1)–(10), (16)–(19): kernel, lattice, bonds |
//! | [`fem`] | eqs. (11)–(15): elements, quadrature, edge loads, recovery |
//! | [`coupling`] | eq. (20): trusses; clipped bonds |
//! | [`interactions`] | what bonds, trusses and clipped bonds have in common: e = w·u |
//! | [`model`] | all of it in one numbering of nodes |
//! | [`boundary`], [`support`] | supports and loads; is the body held? |
//! | [`assembly`], [`linear_solver`], [`statics`] | eqs. (11), (12): K, its factor, U |
//! | [`cracks`], [`fracture`] | eqs. (5), (6): initial cracks, bond laws, load programmes, controls |
//! | [`fields`] | damage, eq. (7), and stress, strain, stretch from U |
//! | [`output`] | VTU, PVD, PNG |
//! | [`pipeline`], [`cli`], [`phases`], [`trace`] | stages and commands; what each phase costs, and when it ran |
//!
//! # Symbols and units
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | x_i | position of a node or material point | m |
//! | u | displacement | m |
//! | ξ, n | bond length, unit vector along the bond | m, – |
//! | s | stretch, n·(u_j − u_i)/ξ | – |
//! | δ, dx, m | horizon, lattice spacing, δ/dx | m, m, – |
//! | A_i, A_FE | area of a material point, of an interface node | m² |
//! | h_t | thickness | m |
//! | g(r), r | kernel, ξ/δ | – |
//! | c, c0 | micromodulus, per unit thickness | N/m⁵ |
//! | M2 | ∫₀^δ g ξ² dξ | m³ |
//! | a, b | coefficients of the isotropised micromodulus c (a + b cos 4φ) | – |
//! | λ_ij, β_ij | factor of a bond near a free surface | – |
//! | k | axial stiffness of a bond or truss | N/m |
//! | E, ν | Young's modulus, Poisson's ratio | Pa, – |
//! | D | elasticity matrix, Voigt order xx, yy, xy | Pa |
//! | ε, γ, σ | strain, engineering shear strain, stress | –, –, Pa |
//! | N_i, B | shape function, strain–displacement matrix | –, 1/m |
//! | t, p | traction, pressure (t = −p n, n outward) | Pa |
//! | K, U, R | stiffness, displacements, loads of all dofs | N/m, m, N |
//!
//! Dof = 2 · node + axis. Voigt vectors hold γ_xy = 2 ε_xy; tensors in files hold ε_xy.
//!
//! # Bibliography
//!
//! The paper:
//! - Qian W., Fan C., Shen F., Xia Y. (2021). Study on hybrid model of peridynamics and finite element
//!   method. Journal of Chongqing University 44(10), 87–94.
//!   doi:10.11835/j.issn.1000-582X.2020.279 (in Chinese).
//!
//! Peridynamics:
//! - Silling S. A., Askari E. (2005). A meshfree method based on the peridynamic model of solid
//!   mechanics. Computers & Structures 83, 1526–1535.
//! - Huang D., Lu G., Wang C., Qiao P. (2015). An extended peridynamic approach for deformation and
//!   fracture analysis. Engineering Fracture Mechanics 141, 196–211. The kernel of eq. (9).
//! - Hu W., Ha Y. D., Bobaru F. (2010). Numerical integration in peridynamics. Technical report,
//!   University of Nebraska–Lincoln. The partial area HHB.
//! - Madenci E., Oterkus E. (2014). Peridynamic Theory and Its Applications. Springer. Surface
//!   correction by two uniaxial strains.
//! - Le Q. V., Bobaru F. (2018). Surface corrections for peridynamic models in elasticity and fracture.
//!   Computational Mechanics 61, 499–518.
//! - Belytschko T., Lu Y. Y., Gu L. (1994). Element-free Galerkin methods. International Journal for
//!   Numerical Methods in Engineering 37, 229–256. The visibility criterion.
//! - Prakash N. (2019). Calibrating bond-based peridynamic parameters using a novel least squares
//!   approach. Journal of Peridynamics and Nonlocal Modeling 1, 45–55.
//!
//! Fracture:
//! - DeJong M. J., Hendriks M. A. N., Rots J. G. (2008). Sequentially linear analysis of fracture under
//!   non-proportional loading. Engineering Fracture Mechanics 75, 5042–5056.
//!
//! Couplings:
//! - Shapeev A. V. (2012). Consistent energy-based atomistic/continuum coupling for two-body potentials
//!   in one and two dimensions. Multiscale Modeling & Simulation 9, 905–932.
//!
//! Finite elements and geometry:
//! - Hinton E., Rock T., Zienkiewicz O. C. (1976). A note on mass lumping and related processes in the
//!   finite element method. Earthquake Engineering & Structural Dynamics 4, 245–249.
//! - Hardy R. J. (1982). Formulas for determining local properties in molecular-dynamics simulations: shock
//!   waves. Journal of Chemical Physics 76, 622–628. <https://doi.org/10.1063/1.442714>
//! - Lehoucq R. B., Silling S. A. (2008). Force flux and the peridynamic stress tensor. Journal of the
//!   Mechanics and Physics of Solids 56, 1566–1577. <https://doi.org/10.1016/j.jmps.2007.08.004>
//! - Barlow J. (1976). Optimal stress locations in finite element models. International Journal for
//!   Numerical Methods in Engineering 10, 243–251.
//! - Muskhelishvili N. I. (1953). Some Basic Problems of the Mathematical Theory of Elasticity. Noordhoff.
//! - Strang G., Fix G. J. (1973). An Analysis of the Finite Element Method. Prentice-Hall.
//! - Dunavant D. A. (1985). High degree efficient symmetrical Gaussian quadrature rules for the
//!   triangle. International Journal for Numerical Methods in Engineering 21, 1129–1148.
//! - Shewchuk J. R. (1997). Adaptive precision floating-point arithmetic and fast robust geometric
//!   predicates. Discrete & Computational Geometry 18, 305–363.
//! - Sutherland I. E., Hodgman G. W. (1974). Reentrant polygon clipping. Communications of the ACM 17,
//!   32–42.
//!
//! Sparse systems:
//! - George A. (1973). Nested dissection of a regular finite element mesh. SIAM Journal on Numerical
//!   Analysis 10, 345–363.
//! - Liu J. W. H. (1990). The role of elimination trees in sparse factorization. SIAM Journal on
//!   Matrix Analysis and Applications 11, 134–172.
//! - Toselli A., Widlund O. (2005). Domain Decomposition Methods – Algorithms and Theory. Springer.
//! - Vaněk P., Mandel J., Brezina M. (1996). Algebraic multigrid by smoothed aggregation for second and
//!   fourth order elliptic problems. Computing 56, 179–196.
//! - Duff I. S., Reid J. K. (1983). The multifrontal solution of indefinite sparse symmetric linear
//!   equations. ACM Transactions on Mathematical Software 9, 302–325.
//! - Liu J. W. H. (1992). The multifrontal method for sparse matrix solution: theory and practice. SIAM
//!   Review 34, 82–109.
//! - Gilbert J. R., Ng E. G., Peyton B. W. (1994). An efficient algorithm to compute row and column counts
//!   for sparse Cholesky factorization. SIAM Journal on Matrix Analysis and Applications 15, 1075–1091.
//! - Davis T. A. (2006). Direct Methods for Sparse Linear Systems. SIAM.
//! - Karypis G., Kumar V. (1998). A fast and high quality multilevel scheme for partitioning irregular
//!   graphs. SIAM Journal on Scientific Computing 20, 359–392.
#![deny(unsafe_code)]
// Units stand in brackets, as in `[m]`, which rustdoc takes for links.
#![allow(rustdoc::broken_intra_doc_links)]

pub mod assembly;
pub mod boundary;
pub mod child;
pub mod cli;
pub mod coupling;
pub mod cracks;
pub mod fem;
pub mod fields;
pub mod fracture;
pub mod geometry;
pub mod gmsh;
pub mod interactions;
pub mod linear_solver;
pub mod material;
pub mod mesh;
pub mod meshio;
pub mod model;
pub mod output;
pub mod peridynamics;
pub mod phases;
pub mod pipeline;

pub mod statics;
pub mod support;
pub mod trace;
pub mod verification;
