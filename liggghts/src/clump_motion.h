// Motion of clumps of two equal spheres, in batches: axisymmetric rigid bodies, leapfrog.
#ifndef BALLAST_CLUMP_MOTION_H
#define BALLAST_CLUMP_MOTION_H

namespace ballast {

/// Up to SIZE clumps. The axis of a clump is the third of its body frame; its spheres lie on it.
struct ClumpBatch {
  static constexpr int SIZE = 16;

  alignas(64) double mass[SIZE];
  alignas(64) double inertia_transverse[SIZE], inertia_axial[SIZE];
  alignas(64) double centre[3][SIZE], velocity[3][SIZE];
  alignas(64) double quaternion[4][SIZE];            ///< (w, x, y, z), body to space
  alignas(64) double axis_x[3][SIZE], axis_y[3][SIZE], axis[3][SIZE];  ///< of the body frame, in space
  alignas(64) double momentum[3][SIZE];              ///< angular, in space
  alignas(64) double spin[3][SIZE];
  alignas(64) double force[3][SIZE], torque[3][SIZE];
  alignas(64) double half_angle2[SIZE], cosine[SIZE], sine_over_angle[SIZE];            ///< of the rotation about the momentum
  alignas(64) double half_turn[SIZE], turn_cosine[SIZE], turn_sine_over_angle[SIZE];    ///< of the rotation about the axis

  ClumpBatch();
};

/// Half a kick and a drift: velocity and momentum over half a step, centre and orientation over a whole one. The free rotation is exact:
/// about the angular momentum by |L| t / I_t, and about the own axis by L.axis (1 / I_a - 1 / I_t) t. spin is that of the middle of the step.
void kick_and_drift(ClumpBatch &clumps, double time_step);

/// The other half of the kick; spin is that of the end of the step.
void kick(ClumpBatch &clumps, double time_step);

/// Cundall's local damping of net force and torque, as YADE's NewtonIntegrator has it: F (1 - alpha sign(F v)), component by component, the
/// force with the velocity `ahead` seconds later, the torque with the present spin.
void damp(ClumpBatch &clumps, double alpha, double ahead);

}  // namespace ballast

#endif
