//! Thresholds of the run, each with its reason.

/// Bonds within this relative distance of the first one break with it: ties by symmetry differ by rounding
/// errors only, and none is decided by an index.
pub const TIE: f64 = 1e-3;

/// A body whose reaction is below this share of its peak is separated: the paper's plates hang by a few bonds
/// then.
pub const SEPARATED: f64 = 0.02;

/// A load that had fallen below this share of its peak has recovered above that, if its least was below this share
/// of itself.
pub const RECOVERED: f64 = 0.5;

/// Cracks are stopped where this share of the last bonds that broke, so many, end at what cannot break.
pub const STOPPED: f64 = 0.9;
pub const LAST_BREAKS: usize = 50;

/// A bond at this share of its limit may break soon: its dofs come in with others.
pub const NEAR: f64 = 0.8;

/// The largest backward error that updates may leave: a factorisation leaves some 1e-17, and load factors are to
/// be right to 1e-9.
pub const DRIFT: f64 = 1e-14;

/// A pivot of I − A S below this share of the largest, or a d = 1 − t w·A w below this: what is left is a
/// mechanism, or too close to one for an update. The factorisation that follows finds out.
pub const LEAST_PIVOT: f64 = 1e-7;

/// More hinges than these at once are for a factorisation to find.
pub const MOST_HINGES: usize = 16;

/// A motion moves a dof that goes farther than this share of the largest: rounding moves the others.
pub const STILL: f64 = 1e-6;

/// By how much u on a zone may differ at its end from the solution there, over the largest: load factors are
/// to be right to 1e-9. Updates leave some 1e-14.
pub const AGREEMENT: f64 = 1e-10;

/// The first event of a zone must be that of the whole model to this share of the load.
pub const SAME_EVENT: f64 = 1e-6;

/// A node with a larger share of its interactions across the edge of the zone is at its rim: those that the
/// zone does not see are close.
pub const RIM_SHARE: f64 = 0.4;

/// Bonds outside a zone must stay under this share of their limits: the zone does not see them.
pub const MARGIN: f64 = 0.95;

/// A zone is used up when a bond at its rim comes nearer than this to its limit, or than halfway to [`MARGIN`]
/// from where it was: those outside are about as near.
pub const RIM: f64 = 0.93;

/// Checks of the bonds next to a zone while it lasts: between two of them they are not followed.
pub const CHECKS: usize = 4;

/// Nodes with a bond at this share of its limit belong to a zone.
pub const STRAINED: f64 = 0.65;

/// Bonds at this share of their limits make a tip.
pub const TIP: f64 = 0.85;

/// The strip ahead of a tip, in horizons: half its width, and how far it goes back; how far apart two tips are;
/// how far back the direction of a crack is read.
pub const HALF_WIDTH: f64 = 1.25;
pub const BACK: f64 = 2.0;
pub const APART: f64 = 2.0;
pub const WAKE: f64 = 4.0;

/// A crack whose broken bonds have their mean this near to the tip has no direction [horizons].
pub const NO_DIRECTION: f64 = 0.1;

/// Nodes as near as this to a bond that makes a tip belong to a zone [horizons]: tips that turn or stand apart
/// from others leave the strips, and a bond whose nodes' families are not seen ends a zone before its first
/// event.
pub const FAMILY: f64 = 1.0;

/// So many times as large as asked may a zone be for the sake of families: where much is strained at once, all of
/// it would be.
pub const LARGEST_ZONE: usize = 2;

/// A look ahead with fewer events than these is followed by updates of the same factor: where much of the body is
/// near its limit, as along an interface, a factorisation for every few events would cost some ten updates each
/// time.
pub const FEWEST_EVENTS: usize = 8;
