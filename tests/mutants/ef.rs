//! Guards of groups E and F: lights and scattering.

use texray::render::Guard;

/// Each guard with the case that fails without it.
pub const MUTANTS: &[(Guard, u8)] = &[
    (Guard::DiscRenormalise, 7),
    (Guard::MisWeight, 38),
    (Guard::SolidAngleEdges, 39),
    (Guard::LightCosine, 43),
    (Guard::HeuristicRatio, 45),
    (Guard::GgxVectorForm, 47),
    (Guard::GgxCancelledCosines, 48),
    (Guard::FresnelProduct, 50),
    (Guard::TotalReflection, 51),
    (Guard::RadianceScale, 53),
    (Guard::BasisSign, 55),
];
