// The parallel bond of Potyondy and Cundall (2004) as plain formulas; the same in words and in Python:
// analysis/bond_law.py. SI units. Body 1 against body 2: the normal points from body 2 to body 1, forces and moments
// act on body 1.
#ifndef BALLAST_BOND_LAW_H
#define BALLAST_BOND_LAW_H

#include <cmath>

namespace ballast {

/// As the deck gives them: per area of the bond's disc (Pa/m, Pa), or of the whole bond (N/m, N).
struct BondConstants {
  double radius_multiplier;
  double normal_stiffness, shear_stiffness;
  double normal_strength, shear_strength;
  bool total;
};

/// Of one bond, per area.
struct BondDisc {
  double radius, area, moment_of_inertia, polar_moment;
  double normal_stiffness, shear_stiffness, normal_strength, shear_strength;
};

enum BondFate { HOLDS = 0, BROKEN_IN_TENSION = 1, BROKEN_IN_SHEAR = 2 };

/// What a bond carries on body 1. The normal force follows from the distance.
struct BondState {
  double rest_distance;  ///< of the centres when it was made, m
  double shear[3];       ///< N
  double twist;          ///< N m, about the normal
  double bending[3];     ///< N m
};

/// Two bodies at one moment, and how they move.
struct BondMotion {
  double normal[3], distance;
  double arm_1, arm_2;                ///< from the centres to the contact point, m
  double velocity[3];                 ///< of centre 1 against centre 2, m/s
  double spin_1[3], spin_2[3];        ///< rad/s
};

struct BondLoad {
  double force[3], moment[3];         ///< on body 1, the force at the contact point
  double tensile_stress, shear_stress;
};

inline double dot(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

inline void cross(const double *a, const double *b, double *c) {
  c[0] = a[1] * b[2] - a[2] * b[1];
  c[1] = a[2] * b[0] - a[0] * b[2];
  c[2] = a[0] * b[1] - a[1] * b[0];
}

inline BondDisc bond_disc(const BondConstants &c, double radius_1, double radius_2) {
  const double pi = 3.14159265358979323846;
  const double radius = c.radius_multiplier * (radius_1 < radius_2 ? radius_1 : radius_2), radius2 = radius * radius;
  const double area = pi * radius2, share = c.total ? 1.0 / area : 1.0;
  const double moment_of_inertia = 0.25 * pi * radius2 * radius2;
  return {radius,
          area,
          moment_of_inertia,
          2.0 * moment_of_inertia,
          share * c.normal_stiffness,
          share * c.shear_stiffness,
          share * c.normal_strength,
          share * c.shear_strength};
}

/// A vector of the contact plane after the contact has moved: turned about the normal by `angle`, then laid into the
/// new plane at its old size.
inline void carry(double *vector, const double *normal, double angle) {
  const double size2 = dot(vector, vector), out = dot(vector, normal);
  double turned[3];
  cross(normal, vector, turned);
  for (int d = 0; d < 3; d++) turned[d] = vector[d] - out * normal[d] + angle * turned[d];
  const double turned2 = dot(turned, turned), keep_size = turned2 > 0.0 ? std::sqrt(size2 / turned2) : 0.0;
  for (int d = 0; d < 3; d++) vector[d] = keep_size * turned[d];
}

/// Take shear force and moments through one step.
inline void advance_bond(const BondDisc &disc, BondState &state, const BondMotion &m, double time_step) {
  double turning[3], mean_spin[3], sliding[3], bend[3];
  for (int d = 0; d < 3; d++) turning[d] = m.arm_1 * m.spin_1[d] + m.arm_2 * m.spin_2[d];
  cross(turning, m.normal, sliding);
  for (int d = 0; d < 3; d++) sliding[d] = m.velocity[d] - sliding[d];
  const double opening = dot(sliding, m.normal);
  for (int d = 0; d < 3; d++) {
    sliding[d] -= opening * m.normal[d];
    mean_spin[d] = 0.5 * (m.spin_1[d] + m.spin_2[d]);
    bend[d] = m.spin_1[d] - m.spin_2[d];
  }
  const double twist = dot(bend, m.normal), angle = dot(mean_spin, m.normal) * time_step;
  carry(state.shear, m.normal, angle);
  carry(state.bending, m.normal, angle);
  state.twist -= disc.shear_stiffness * disc.polar_moment * twist * time_step;
  for (int d = 0; d < 3; d++) {
    state.shear[d] -= disc.shear_stiffness * disc.area * sliding[d] * time_step;
    state.bending[d] -= disc.normal_stiffness * disc.moment_of_inertia * (bend[d] - twist * m.normal[d]) * time_step;
  }
}

inline BondLoad bond_load(const BondDisc &disc, const BondState &state, const BondMotion &m) {
  BondLoad load;
  const double normal_force = -disc.normal_stiffness * disc.area * (m.distance - state.rest_distance);
  for (int d = 0; d < 3; d++) {
    load.force[d] = normal_force * m.normal[d] + state.shear[d];
    load.moment[d] = state.twist * m.normal[d] + state.bending[d];
  }
  const double bending = std::sqrt(dot(state.bending, state.bending)), shear = std::sqrt(dot(state.shear, state.shear));
  load.tensile_stress = -normal_force / disc.area + bending * disc.radius / disc.moment_of_inertia;
  load.shear_stress = shear / disc.area + std::fabs(state.twist) * disc.radius / disc.polar_moment;
  return load;
}

/// What the load makes of the bond.
inline BondFate bond_fate(const BondDisc &disc, const BondLoad &load) {
  const double tension = load.tensile_stress / disc.normal_strength, shear = load.shear_stress / disc.shear_strength;
  if (tension < 1.0 && shear < 1.0) return HOLDS;
  return tension >= shear ? BROKEN_IN_TENSION : BROKEN_IN_SHEAR;
}

}  // namespace ballast

#endif
