#include "material.h"

#include <mpi.h>

#include <cstring>
#include <string>

#include "contact_laws.h"
#include "fix_property_global.h"
#include "lammps.h"
#include "modify.h"
#include "stop_with_error.h"

using namespace LAMMPS_NS;

namespace ballast {

namespace {

/// The `fix property/global` of that name, or null.
FixPropertyGlobal *find_property(LAMMPS *lmp, const char *name, const char *kind) {
  return static_cast<FixPropertyGlobal *>(
      lmp->modify->find_fix_property(name, "property/global", kind, 0, 0, "ballast", false));
}

double pair_value(LAMMPS *lmp, const char *name, int a, int b) {
  FixPropertyGlobal *property = find_property(lmp, name, "peratomtypepair");
  if (!property)
    stop_with_error(lmp, std::string(name) + ": missing; the deck needs `fix ID all property/global " + name +
                             " peratomtypepair ...`");
  return property->compute_array(a - 1, b - 1);
}

double scalar_value(LAMMPS *lmp, const char *name, const double *otherwise) {
  FixPropertyGlobal *property = find_property(lmp, name, "scalar");
  if (!property && otherwise) return *otherwise;
  if (!property)
    stop_with_error(
        lmp, std::string(name) + ": missing; the deck needs `fix ID all property/global " + name + " scalar ...`");
  return property->compute_scalar();
}

}  // namespace

ContactConstants read_material(LAMMPS *lmp, int a, int b, bool hysteretic) {
  const double whole = 1.0;
  ContactConstants c = {};
  c.hysteretic = hysteretic;
  c.friction = pair_value(lmp, "slipFriction", a, b);
  c.mass_share = scalar_value(lmp, "dashpotMassShare", &whole);
  if (!hysteretic) {
    c.normal_stiffness = pair_value(lmp, "normalStiffness", a, b);
    c.shear_stiffness = pair_value(lmp, "shearStiffness", a, b);
    c.damping_ratio = pair_value(lmp, "dampingRatio", a, b);
    return c;
  }
  c.shear_modulus = pair_value(lmp, "shearModulus", a, b);
  c.poisson_ratio = pair_value(lmp, "contactPoissonRatio", a, b);
  c.dashpot_limit = scalar_value(lmp, "dashpotLimit", &whole);
  const double restitution = pair_value(lmp, "nominalRestitution", a, b), mode = scalar_value(lmp, "dampingMode", NULL);
  if (mode != 0.0 && mode != 1.0 && mode != 2.0)
    stop_with_error(lmp, "dampingMode: must be 0, 1 or 2; correct the fix property/global");
  if (mode == 0.0 && restitution == 0.0)
    stop_with_error(lmp,
                    "nominalRestitution: 0 with dampingMode 0 is singular; give a restitution above 0 or another mode");
  c.damping_factor = damping_factor(restitution, static_cast<int>(mode));
  return c;
}

}  // namespace ballast
