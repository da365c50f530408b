#include "clump_motion.h"

#include <algorithm>
#include <cmath>

#include "clones.h"

namespace ballast {

namespace {

const int BATCH = 16;

/// Below this square of a half angle the series of cosine and sine are exact to the last digit.
const double SMALL2 = 0.01;

inline double sign(double value) { return value > 0.0 ? 1.0 : (value < 0.0 ? -1.0 : 0.0); }

inline double cosine_series(double h2) {
  return 1.0 - h2 * (1.0 / 2.0 - h2 * (1.0 / 24.0 - h2 * (1.0 / 720.0 - h2 * (1.0 / 40320.0 - h2 / 3628800.0))));
}

inline double sine_over_angle_series(double h2) {
  return 1.0 - h2 * (1.0 / 6.0 - h2 * (1.0 / 120.0 - h2 * (1.0 / 5040.0 - h2 * (1.0 / 362880.0 - h2 / 39916800.0))));
}

/// Rotations of up to BATCH clumps in a step: half angles about the momentum (squared) and about the axis, their
/// cosines and sines.
struct Rotations {
  double half_angle2[BATCH], cosine[BATCH], sine_over_angle[BATCH];
  double half_turn[BATCH], turn_cosine[BATCH], turn_sine_over_angle[BATCH];
};

/// Returns the largest square of a half angle.
BALLAST_CLONES double kick_and_find_angles(const Clumps &c, int first, int count, double time_step, Rotations &turn) {
  const double half = 0.5 * time_step, per_mass = half / c.mass, across = 1.0 / c.inertia_transverse;
  const double difference = 1.0 / c.inertia_axial - across;
  double *const centre = c.centre + 3 * first, *const velocity = c.velocity + 3 * first,
                *const momentum = c.momentum + 3 * first;
  const double *const force = c.force + 3 * first, *const torque = c.torque + 3 * first,
                      *const axis = c.axis + 3 * first;
#pragma omp simd
  for (int n = 0; n < 3 * count; n++) {
    velocity[n] += per_mass * force[n];
    centre[n] += time_step * velocity[n];
    momentum[n] += half * torque[n];
  }
  double largest = 0.0;
#pragma omp simd reduction(max : largest)
  for (int k = 0; k < count; k++) {
    const double lx = momentum[3 * k], ly = momentum[3 * k + 1], lz = momentum[3 * k + 2];
    const double scale = half * across;
    const double h2 = scale * scale * (lx * lx + ly * ly + lz * lz);
    const double t = half * difference * (lx * axis[3 * k] + ly * axis[3 * k + 1] + lz * axis[3 * k + 2]), t2 = t * t;
    turn.half_angle2[k] = h2;
    turn.half_turn[k] = t;
    turn.cosine[k] = cosine_series(h2);
    turn.sine_over_angle[k] = sine_over_angle_series(h2);
    turn.turn_cosine[k] = cosine_series(t2);
    turn.turn_sine_over_angle[k] = sine_over_angle_series(t2);
    const double more = h2 > t2 ? h2 : t2;
    largest = more > largest ? more : largest;
  }
  return largest;
}

/// For spins that no bed has.
void exact_angles(int count, Rotations &turn) {
  for (int k = 0; k < count; k++) {
    const double h = std::sqrt(turn.half_angle2[k]), t = turn.half_turn[k];
    turn.cosine[k] = std::cos(h);
    turn.sine_over_angle[k] = h > 0.0 ? std::sin(h) / h : 1.0;
    turn.turn_cosine[k] = std::cos(t);
    turn.turn_sine_over_angle[k] = t != 0.0 ? std::sin(t) / t : 1.0;
  }
}

BALLAST_CLONES void apply(const Clumps &c, int first, int count, double time_step, const Rotations &turn) {
  const double across = 1.0 / c.inertia_transverse, difference = 1.0 / c.inertia_axial - across, half = 0.5 * time_step;
  double *const quaternion = c.quaternion + 4 * first, *const spin = c.spin + 3 * first;
  double *const ex = c.axis_x + 3 * first, *const ey = c.axis_y + 3 * first, *const ez = c.axis + 3 * first;
  const double *const momentum = c.momentum + 3 * first;
#pragma omp simd
  for (int k = 0; k < count; k++) {
    const double lx = momentum[3 * k], ly = momentum[3 * k + 1], lz = momentum[3 * k + 2];
    // new quaternion = rotation about L (space) x old x rotation about the axis (body)
    const double scale = half * across * turn.sine_over_angle[k];
    const double pw = turn.cosine[k], px = scale * lx, py = scale * ly, pz = scale * lz;
    const double qw = quaternion[4 * k], qx = quaternion[4 * k + 1], qy = quaternion[4 * k + 2],
                 qz = quaternion[4 * k + 3];
    const double aw = pw * qw - px * qx - py * qy - pz * qz;
    const double ax = pw * qx + px * qw + py * qz - pz * qy;
    const double ay = pw * qy + py * qw + pz * qx - px * qz;
    const double az = pw * qz + pz * qw + px * qy - py * qx;
    const double sw = turn.turn_cosine[k], sz = turn.half_turn[k] * turn.turn_sine_over_angle[k];
    double w = aw * sw - az * sz, x = ax * sw + ay * sz, y = ay * sw - ax * sz, z = az * sw + aw * sz;
    const double unit = 1.0 / std::sqrt(w * w + x * x + y * y + z * z);
    w *= unit;
    x *= unit;
    y *= unit;
    z *= unit;
    quaternion[4 * k] = w;
    quaternion[4 * k + 1] = x;
    quaternion[4 * k + 2] = y;
    quaternion[4 * k + 3] = z;
    const double nx = 2.0 * (x * z + w * y), ny = 2.0 * (y * z - w * x), nz = w * w - x * x - y * y + z * z;
    // the axis in the middle of the step: the mean of both ends, within the square of the angle
    const double mx = 0.5 * (nx + ez[3 * k]), my = 0.5 * (ny + ez[3 * k + 1]), mz = 0.5 * (nz + ez[3 * k + 2]);
    const double along = difference * (lx * mx + ly * my + lz * mz);
    spin[3 * k] = lx * across + along * mx;
    spin[3 * k + 1] = ly * across + along * my;
    spin[3 * k + 2] = lz * across + along * mz;
    ez[3 * k] = nx;
    ez[3 * k + 1] = ny;
    ez[3 * k + 2] = nz;
    ex[3 * k] = w * w + x * x - y * y - z * z;
    ex[3 * k + 1] = 2.0 * (x * y + w * z);
    ex[3 * k + 2] = 2.0 * (x * z - w * y);
    ey[3 * k] = 2.0 * (x * y - w * z);
    ey[3 * k + 1] = w * w - x * x + y * y - z * z;
    ey[3 * k + 2] = 2.0 * (y * z + w * x);
  }
}

}  // namespace

void kick_and_drift(const Clumps &clumps, double time_step) {
  Rotations turn;
  for (int first = 0; first < clumps.number; first += BATCH) {
    const int count = std::min(BATCH + 0, clumps.number - first);
    if (kick_and_find_angles(clumps, first, count, time_step, turn) > SMALL2) exact_angles(count, turn);
    apply(clumps, first, count, time_step, turn);
  }
}

BALLAST_CLONES void kick(const Clumps &c, double time_step) {
  const double half = 0.5 * time_step, per_mass = half / c.mass, across = 1.0 / c.inertia_transverse;
  const double difference = 1.0 / c.inertia_axial - across;
  double *const velocity = c.velocity, *const momentum = c.momentum, *const spin = c.spin;
  const double *const force = c.force, *const torque = c.torque, *const axis = c.axis;
#pragma omp simd
  for (int n = 0; n < 3 * c.number; n++) {
    velocity[n] += per_mass * force[n];
    momentum[n] += half * torque[n];
  }
#pragma omp simd
  for (int k = 0; k < c.number; k++) {
    const double lx = momentum[3 * k], ly = momentum[3 * k + 1], lz = momentum[3 * k + 2];
    const double nx = axis[3 * k], ny = axis[3 * k + 1], nz = axis[3 * k + 2];
    const double along = difference * (lx * nx + ly * ny + lz * nz);
    spin[3 * k] = lx * across + along * nx;
    spin[3 * k + 1] = ly * across + along * ny;
    spin[3 * k + 2] = lz * across + along * nz;
  }
}

BALLAST_CLONES void damp(const Clumps &c, double alpha, double ahead) {
  const double per_mass = ahead / c.mass;
  double *const force = c.force, *const torque = c.torque;
  const double *const velocity = c.velocity, *const spin = c.spin;
#pragma omp simd
  for (int n = 0; n < 3 * c.number; n++) {
    force[n] *= 1.0 - alpha * sign(force[n] * (velocity[n] + per_mass * force[n]));
    torque[n] *= 1.0 - alpha * sign(torque[n] * spin[n]);
  }
}

}  // namespace ballast
