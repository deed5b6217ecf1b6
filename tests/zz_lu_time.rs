mod common;
use common::*;
use peristitch::coupling::Coupling;
use peristitch::material::PlaneState;
use peristitch::mesh::CellKind;
use peristitch::model::*;
use peristitch::peridynamics::lattice::Placement;
use peristitch::phases::Phases;
use peristitch::statics;
#[test]
fn times() {
    for (n, coupling) in [
        (100usize, Coupling::Splice),
        (
            100,
            Coupling::Truss(peristitch::coupling::truss::NodeArea::Lumped),
        ),
        (200, Coupling::Splice),
        (
            200,
            Coupling::Truss(peristitch::coupling::truss::NodeArea::Lumped),
        ),
    ] {
        let dx = 1e-3;
        let mut mesh = Grid {
            size: [n as f64 * dx, 1.4 * n as f64 * dx],
            count: [n / 4, n / 4 * 14 / 10],
            kind: CellKind::Quad8,
        }
        .plain();
        let h = 1.4 * n as f64 * dx / (n / 4 * 14 / 10) as f64;
        let (a, b) = (
            (n as f64 * 0.2 * dx / h).round() * h,
            (n as f64 * 1.2 * dx / h).round() * h,
        );
        let within = |[_, y]: [f64; 2]| a < y && y < b;
        name_cells(&mut mesh, "island", within);
        name_cells(&mut mesh, "around", |x| !within(x));
        name_curve(&mut mesh, "top", |[_, y]| y > 1.4 * n as f64 * dx - 1e-9);
        name_curve(&mut mesh, "bottom", |[_, y]| y < 1e-9);
        let method = Method::Peridynamics(paper_lattice(dx, Placement::CellCentred));
        let regions = vec![
            region(&mesh, &["around"], steel(), Method::FiniteElements),
            region(&mesh, &["island"], steel(), method),
        ];
        let model = Model::build(
            mesh,
            regions,
            ModelSettings {
                plane: PlaneState::Stress,
                thickness: 1.0,
                coupling,
            },
        )
        .expect("model");
        let mut boundary = peristitch::boundary::Boundary::new(&model);
        boundary
            .displace(&model, "top", [Some(0.0), Some(1e-6)])
            .expect("x");
        boundary
            .displace(&model, "bottom", [Some(0.0), Some(0.0)])
            .expect("x");
        if let Some(splice) = &model.splice {
            use faer::sparse::linalg::lu::*;
            let eq = model.equations(splice);
            let pat = peristitch::assembly::full::FullPattern::new(
                model.node_count(),
                model.fe_node_count() as u32,
                &model.springs,
                &eq,
            );
            let k = pat.assemble(&model.positions, &model.springs, &eq);
            let t = std::time::Instant::now();
            let sym = factorize_symbolic_lu(
                k.symbolic(),
                LuSymbolicParams {
                    supernodal_flop_ratio_threshold:
                        faer::sparse::linalg::SupernodalThreshold::FORCE_SUPERNODAL,
                    ..Default::default()
                },
            )
            .expect("s");
            let mut num = NumericLu::new();
            let mut mem = faer::dyn_stack::MemBuffer::new(
                sym.factorize_numeric_lu_scratch::<f64>(faer::Par::Seq, Default::default()),
            );
            sym.factorize_numeric_lu(
                &mut num,
                k.as_ref(),
                faer::Par::Seq,
                faer::dyn_stack::MemStack::new(&mut mem),
                Default::default(),
            )
            .expect("n");
            println!("COLAMD {:?}", t.elapsed());
        }
        let mut phases = Phases::default();
        let solution = statics::solve(&model, &boundary, &mut phases).expect("solution");
        println!(
            "{n} {coupling:?} {:?} {:.1e}",
            solution.size, solution.residual
        );
        for p in &phases.list {
            println!("   {} {:?}", p.name, p.time);
        }
        let r = statics::group_reactions(&boundary, &solution.reaction);
        println!("   {r:?}");
    }
}
