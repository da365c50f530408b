// Motion of clumps of two equal spheres: axisymmetric rigid bodies, leapfrog.
#ifndef BALLAST_CLUMP_MOTION_H
#define BALLAST_CLUMP_MOTION_H

namespace ballast {

/// All clumps of a rank: arrays of LIGGGHTS' fix multisphere, three numbers per clump (four of a quaternion, (w, x, y,
/// z), body to space). All have one mass and one inertia. The axis of a clump is the third of its body frame; its
/// spheres lie on it.
struct Clumps {
  int number;
  double mass, inertia_transverse, inertia_axial;
  double *centre, *velocity, *quaternion, *axis_x, *axis_y, *axis;
  double *momentum, *spin;       ///< angular momentum and velocity, in space
  double *force, *torque;
};

/// Half a kick and a drift: velocity and momentum over half a step, centre and orientation over a whole one. The free
/// rotation is exact: about the angular momentum by |L| t / I_t, and about the own axis by L.axis (1 / I_a - 1 / I_t)
/// t. spin is that of the middle of the step.
void kick_and_drift(const Clumps &clumps, double time_step);

/// The other half of the kick; spin is that of the end of the step.
void kick(const Clumps &clumps, double time_step);

/// Cundall's local damping of net force and torque, as YADE's NewtonIntegrator has it: F (1 - alpha sign(F v)),
/// component by component, the force with the velocity `ahead` seconds later, the torque with the present spin.
void damp(const Clumps &clumps, double alpha, double ahead);

}  // namespace ballast

#endif
