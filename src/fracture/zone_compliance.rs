//! X = L⁻¹ E and A = Xᵀ X of the dofs of a zone. Zones on the same factor that end early share most of their dofs,
//! whose X and A are taken over.

use super::rates::{LEAST_SHARED, MOST_BLOCKS};
use crate::linear_solver::columns::slice_mut;
use crate::linear_solver::compliance::UnitLoads;
use crate::statics::Factorised;
use faer::Mat;
use rayon::prelude::*;

/// X and A of the dofs of a zone.
pub struct ZoneCompliance {
    /// The dofs, ascending.
    dofs: Vec<usize>,
    pub loads: UnitLoads,
    /// A [m/N].
    pub own: Mat<f64>,
    /// Multiplications and additions that it took.
    pub flops: f64,
}

impl ZoneCompliance {
    /// X and A of these dofs; `before` is that of another zone on the same factor. `None` where the factor is not Cholesky's.
    pub fn new(
        factorised: &Factorised,
        dofs: &[usize],
        before: Option<ZoneCompliance>,
    ) -> Option<ZoneCompliance> {
        if let Some(before) = &before
            && let Some(shared) = Shared::new(before, dofs)
        {
            return shared.extend(factorised, dofs);
        }
        drop(before);
        ZoneCompliance::of(factorised, dofs)
    }

    fn of(factorised: &Factorised, dofs: &[usize]) -> Option<ZoneCompliance> {
        let loads = factorised.unit_loads(dofs)?;
        let size = dofs.len() as f64;
        Some(ZoneCompliance {
            flops: loads.flops + size * size * loads.rows() as f64,
            own: loads.square(),
            dofs: dofs.to_vec(),
            loads,
        })
    }
}

/// Dofs that a zone shares with the one before.
struct Shared<'a> {
    before: &'a ZoneCompliance,
    /// Place of each dof in the zone before, if it was there, and place of each dof before in this zone.
    source: Vec<Option<usize>>,
    target: Vec<Option<usize>>,
}

impl Shared<'_> {
    fn new<'a>(before: &'a ZoneCompliance, dofs: &[usize]) -> Option<Shared<'a>> {
        let find = |list: &[usize], dof: &usize| list.binary_search(dof).ok();
        let source: Vec<Option<usize>> = dofs.iter().map(|dof| find(&before.dofs, dof)).collect();
        let count = source.iter().flatten().count();
        let is_worth_it =
            count as f64 >= LEAST_SHARED * dofs.len() as f64 && before.loads.blocks() < MOST_BLOCKS;
        is_worth_it.then(|| Shared {
            target: before.dofs.iter().map(|dof| find(dofs, dof)).collect(),
            before,
            source,
        })
    }

    fn extend(&self, factorised: &Factorised, dofs: &[usize]) -> Option<ZoneCompliance> {
        let places = 0..dofs.len();
        let fresh: Vec<usize> = places.filter(|&k| self.source[k].is_none()).collect();
        let fresh_dofs: Vec<usize> = fresh.iter().map(|&k| dofs[k]).collect();
        let fresh_loads = factorised.unit_loads(&fresh_dofs)?;
        let mut loads = UnitLoads::default();
        loads.take(&self.before.loads, &self.target);
        let target: Vec<Option<usize>> = fresh.iter().map(|&k| Some(k)).collect();
        loads.take(&fresh_loads, &target);
        let products = fresh_loads.product(&loads);
        let mut own = self.known();
        for (k, &place) in fresh.iter().enumerate() {
            for (j, &product) in products.row(k).iter().enumerate() {
                own[(place, j)] = product;
                own[(j, place)] = product;
            }
        }
        let sizes = 2.0 * (fresh.len() * dofs.len()) as f64;
        Some(ZoneCompliance {
            flops: fresh_loads.flops + sizes * loads.rows() as f64,
            own,
            dofs: dofs.to_vec(),
            loads,
        })
    }

    /// A of the dofs that are shared; zero for the others.
    fn known(&self) -> Mat<f64> {
        let size = self.source.len();
        let mut own = Mat::zeros(size, size);
        let columns = own.par_col_iter_mut().zip(&self.source);
        columns.for_each(|(column, source)| {
            let Some(from) = *source else { return };
            let from = self.before.own.col(from);
            let entries = slice_mut(column).iter_mut().zip(&self.source);
            for (entry, source) in entries {
                *entry = source.map_or(0.0, |i| from[i]);
            }
        });
        own
    }
}
