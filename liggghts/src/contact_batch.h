// Contacts are evaluated in batches, normal and shear force together: pairs of spheres and spheres at walls fill the
// same batch, so that there is one contact law in this program.
#ifndef BALLAST_CONTACT_BATCH_H
#define BALLAST_CONTACT_BATCH_H

namespace ballast {

/// Constants of the law between one pair of materials.
struct ContactConstants {
  bool hysteretic;
  double normal_stiffness, shear_stiffness;  ///< linear law, N/m
  double damping_ratio;                      ///< linear law, share of critical damping
  double shear_modulus, poisson_ratio;       ///< hysteretic law; Pa, -
  double damping_factor;                     ///< hysteretic law, D of eq. 16
  double dashpot_limit;  ///< hysteretic law, most that its dashpot may be, share of critical damping
  double mass_share;  ///< share of the effective mass in the dashpots; 1 = whole clumps
  double friction;
};

/// What a contact remembers from step to step.
struct ContactHistory {
  double last_touch_step;
  double shear[3];  ///< shear force on sphere i, N
  double impact_speed;  ///< m/s; used by the hysteretic law only
};

/// Up to SIZE contacts of a sphere i with a partner j, or with a wall (its radius and spin are 0, its mass infinite).
struct ContactBatch {
  static constexpr int SIZE = 16;

  // filled by the caller: position, velocity and spin; distance = centre i - centre j, or - nearest point of the wall
  double distance[3][SIZE];
  double velocity[3][SIZE];  ///< of i relative to the partner, m/s
  double spin_i[3][SIZE], spin_j[3][SIZE];
  double radius_i[SIZE], radius_j[SIZE];
  double side[SIZE];  ///< 1; -1 where the centre of i lies inside the wall
  double effective_mass[SIZE];  ///< m1 m2 / (m1 + m2), or m1 at a wall
  double effective_radius[SIZE];  ///< 2 R1 R2 / (R1 + R2), or 2 R1 at a wall
  // history: read, and replaced by what is to be remembered
  double last_touch_step[SIZE];
  double shear[3][SIZE];
  double impact_speed[SIZE];
  // results
  double normal[3][SIZE];
  double overlap[SIZE];
  double normal_force[SIZE];
  double force[3][SIZE];  ///< on i, N
  double turn[3][SIZE];  ///< normal x shear force; torque on i is -arm_i turn, on j -arm_j turn
  double arm_i[SIZE], arm_j[SIZE];
  double sliding[SIZE], dashpot_at_limit[SIZE];  ///< 0 or 1

  ContactBatch();
};

/// Forces and new histories of all contacts of the batch. step is the present one, time_step in s. With advance = false
/// the shear forces are those of the last step: nothing moves on (set-up of a run, output).
void evaluate(const ContactConstants &constants, ContactBatch &batch, double step, double time_step, bool advance);

}  // namespace ballast

#endif
