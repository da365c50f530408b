#include "contact_batch.h"

#include <cstring>

#include "clones.h"
#include "contact_laws.h"

namespace ballast {

ContactBatch::ContactBatch() { std::memset(static_cast<void *>(this), 0, sizeof(*this)); }

namespace {

typedef double Lanes[ContactBatch::SIZE];

/// All lanes are computed, also those without a contact: their results are not looked at.
template <bool HYSTERETIC, bool ADVANCE>
inline __attribute__((always_inline)) void evaluate_lanes(const ContactConstants &c, ContactBatch &b, double step,
                                                          double time_step) {
  double fresh[ContactBatch::SIZE];  // in a loop of its own: GCC 12 does not vectorise the comparison beside the rest
  for (int k = 0; k < ContactBatch::SIZE; k++) fresh[k] = is_new_contact(b.last_touch_step[k], step) ? 1.0 : 0.0;
#pragma omp simd
  for (int k = 0; k < ContactBatch::SIZE; k++) {
    // geometry: unit normal from the partner to i, overlap, arms from the centres to the middle of the overlap
    const double dx = b.distance[0][k], dy = b.distance[1][k], dz = b.distance[2][k];
    const double r = std::sqrt(dx * dx + dy * dy + dz * dz), inverse = 1.0 / r;
    const double nx = dx * inverse, ny = dy * inverse, nz = dz * inverse;
    const double overlap = b.radius_i[k] + b.radius_j[k] - b.side[k] * r;
    const double arm_i = b.radius_i[k] - 0.5 * overlap, arm_j = b.radius_j[k] - 0.5 * overlap;

    // relative velocity at the contact: normal, and tangential with the spins
    const double vx = b.velocity[0][k], vy = b.velocity[1][k], vz = b.velocity[2][k];
    const double vn = vx * nx + vy * ny + vz * nz, closing = -vn;
    const double ix = b.spin_i[0][k], iy = b.spin_i[1][k], iz = b.spin_i[2][k];
    const double jx = b.spin_j[0][k], jy = b.spin_j[1][k], jz = b.spin_j[2][k];
    const double wx = arm_i * ix + arm_j * jx, wy = arm_i * iy + arm_j * jy, wz = arm_i * iz + arm_j * jz;
    const double tx = vx - vn * nx - (nz * wy - ny * wz);
    const double ty = vy - vn * ny - (nx * wz - nz * wx);
    const double tz = vz - vn * nz - (ny * wx - nx * wy);

    // normal force
    const bool is_new = fresh[k] != 0.0;
    const double mass = c.mass_share * b.effective_mass[k];
    NormalResponse response;
    if (HYSTERETIC) {
      const double first_speed = existed_before(overlap, closing, time_step) ? 0.0 : closing;
      const double impact_speed = is_new ? first_speed : b.impact_speed[k];
      b.impact_speed[k] = impact_speed;
      response = hysteretic_normal(overlap, closing, impact_speed, mass, b.effective_radius[k], c.shear_modulus,
                                   c.poisson_ratio, c.damping_factor, c.dashpot_limit);
    } else {
      response = linear_normal(overlap, closing, mass, c.normal_stiffness, c.shear_stiffness, c.damping_ratio);
    }

    // shear force of the last step, turned with the contact (about the normal by the mean spin of the two bodies, then
    // into the new contact plane; its size stays), and the increment of this step (eq. 3-4)
    double sx = is_new ? 0.0 : b.shear[0][k], sy = is_new ? 0.0 : b.shear[1][k], sz = is_new ? 0.0 : b.shear[2][k];
    if (ADVANCE) {
      const double angle = 0.5 * time_step * ((ix + jx) * nx + (iy + jy) * ny + (iz + jz) * nz);
      const double out = sx * nx + sy * ny + sz * nz;
      const double ux = sx - out * nx + angle * (ny * sz - nz * sy);
      const double uy = sy - out * ny + angle * (nz * sx - nx * sz);
      const double uz = sz - out * nz + angle * (nx * sy - ny * sx);
      const double size2 = sx * sx + sy * sy + sz * sz, turned2 = ux * ux + uy * uy + uz * uz;
      const double keep_size = std::sqrt(size2 / (turned2 > 0.0 ? turned2 : 1.0));
      const double share = is_new ? touching_share(overlap, closing, time_step) : 1.0;
      const double increment = response.shear_stiffness * time_step * share;
      sx = keep_size * ux - increment * tx;
      sy = keep_size * uy - increment * ty;
      sz = keep_size * uz - increment * tz;
    }

    // friction limits it by the elastic part of the normal force
    const double limit = c.friction * response.elastic_force;
    const double size2 = sx * sx + sy * sy + sz * sz, size = std::sqrt(size2);
    const double cut = size2 > limit * limit ? limit / size : 1.0;
    sx *= cut;
    sy *= cut;
    sz *= cut;

    b.normal[0][k] = nx;
    b.normal[1][k] = ny;
    b.normal[2][k] = nz;
    b.overlap[k] = overlap;
    b.arm_i[k] = arm_i;
    b.arm_j[k] = arm_j;
    b.normal_force[k] = response.total_force;
    b.dashpot_at_limit[k] = response.dashpot_at_limit;
    // the stored force of a sliding contact lies on the limit, within rounding
    b.sliding[k] = size2 >= limit * limit * (1.0 - 1e-12) ? 1.0 : 0.0;
    b.last_touch_step[k] = step;
    b.shear[0][k] = sx;
    b.shear[1][k] = sy;
    b.shear[2][k] = sz;
    b.force[0][k] = response.total_force * nx + sx;
    b.force[1][k] = response.total_force * ny + sy;
    b.force[2][k] = response.total_force * nz + sz;
    b.turn[0][k] = ny * sz - nz * sy;
    b.turn[1][k] = nz * sx - nx * sz;
    b.turn[2][k] = nx * sy - ny * sx;
  }
}

BALLAST_CLONES void advance_linear(const ContactConstants &c, ContactBatch &b, double step, double time_step) {
  evaluate_lanes<false, true>(c, b, step, time_step);
}

BALLAST_CLONES void advance_hysteretic(const ContactConstants &c, ContactBatch &b, double step, double time_step) {
  evaluate_lanes<true, true>(c, b, step, time_step);
}

BALLAST_CLONES void repeat_linear(const ContactConstants &c, ContactBatch &b, double step, double time_step) {
  evaluate_lanes<false, false>(c, b, step, time_step);
}

BALLAST_CLONES void repeat_hysteretic(const ContactConstants &c, ContactBatch &b, double step, double time_step) {
  evaluate_lanes<true, false>(c, b, step, time_step);
}

}  // namespace

void evaluate(const ContactConstants &constants, ContactBatch &batch, double step, double time_step, bool advance) {
  if (constants.hysteretic)
    (advance ? advance_hysteretic : repeat_hysteretic)(constants, batch, step, time_step);
  else
    (advance ? advance_linear : repeat_linear)(constants, batch, step, time_step);
}

}  // namespace ballast
