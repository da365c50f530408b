// Material properties of the contact models: decks give them as `fix ID all property/global NAME peratomtypepair ...` (or scalar).
#ifndef BALLAST_PROPERTY_ACCESS_H
#define BALLAST_PROPERTY_ACCESS_H

#include "global_properties.h"

namespace ballast {

static constexpr const char *NORMAL_STIFFNESS = "normalStiffness";    // N/m
static constexpr const char *SHEAR_STIFFNESS = "shearStiffness";      // N/m
static constexpr const char *DAMPING_RATIO = "dampingRatio";          // share of critical damping
static constexpr const char *SLIP_FRICTION = "slipFriction";          // -
static constexpr const char *SHEAR_MODULUS = "shearModulus";          // Pa
static constexpr const char *POISSON_RATIO = "contactPoissonRatio";   // -
static constexpr const char *RESTITUTION = "nominalRestitution";      // -, nominal e_n of eq. 16
static constexpr const char *DAMPING_MODE = "dampingMode";            // scalar, M_d of eq. 16

template <const char *const *NAME>
MatrixProperty *create_pair_property(PropertyRegistry &registry, const char *caller, bool) {
  return MODEL_PARAMS::createPerTypePairProperty(registry, *NAME, caller);
}

template <const char *const *NAME>
ScalarProperty *create_scalar_property(PropertyRegistry &registry, const char *caller, bool) {
  return MODEL_PARAMS::createScalarProperty(registry, *NAME, caller);
}

/// Connect `values` to the property NAME of every pair of types.
template <const char *const *NAME>
void connect_pair_property(PropertyRegistry &registry, double **&values, const char *caller) {
  registry.registerProperty(*NAME, &create_pair_property<NAME>);
  registry.connect(*NAME, values, caller);
}

/// Connect `value` to the scalar property NAME.
template <const char *const *NAME>
void connect_scalar_property(PropertyRegistry &registry, double &value, const char *caller) {
  registry.registerProperty(*NAME, &create_scalar_property<NAME>);
  registry.connect(*NAME, value, caller);
}

}  // namespace ballast

#endif
