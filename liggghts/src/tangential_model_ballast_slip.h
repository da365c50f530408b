#ifdef TANGENTIAL_MODEL
TANGENTIAL_MODEL(BALLAST_SLIP, ballast/slip, 40)
#else
#ifndef TANGENTIAL_MODEL_BALLAST_SLIP_H_
#define TANGENTIAL_MODEL_BALLAST_SLIP_H_

#include "contact_laws.h"
#include "contact_models.h"
#include "contact_recorder.h"
#include "property_access.h"
#include "tangential_model_base.h"
#include "update.h"

namespace LIGGGHTS {
namespace ContactModels {

/// `tangential ballast/slip`: shear force grown in increments of force and limited by friction on the elastic normal force (eq. 3-4).
template <>
class TangentialModel<BALLAST_SLIP> : public TangentialModelBase {
 public:
  TangentialModel(LAMMPS *lmp, IContactHistorySetup *setup, class ContactModelBase *model)
      : TangentialModelBase(lmp, setup, model), friction_(NULL), last_touch_(model->get_history_offset("last_touch_step")),
        shear_(setup->add_history_value("shear_x", "1")) {
    setup->add_history_value("shear_y", "1");
    setup->add_history_value("shear_z", "1");
  }

  void registerSettings(Settings &) {}
  void postSettings(IContactHistorySetup *, ContactModelBase *) {}

  void connectToProperties(PropertyRegistry &registry) {
    ballast::connect_pair_property<&ballast::SLIP_FRICTION>(registry, friction_, "ballast/slip");
  }

  inline void surfacesIntersect(const SurfacesIntersectData &contact, ForceData &on_i, ForceData &on_j) {
    if (contact.contact_flags) *contact.contact_flags |= CONTACT_TANGENTIAL_MODEL;
    double *const history = contact.contact_history;
    const double step = static_cast<double>(update->ntimestep);
    const bool advance = contact.computeflag && contact.shearupdate;
    double shear[3] = {0.0, 0.0, 0.0};
    double increment = contact.kt * update->dt;
    if (ballast::is_new_contact(history[last_touch_], step))
      increment *= ballast::touching_share(contact.deltan, -contact.vn, update->dt);
    else
      for (int d = 0; d < 3; d++) shear[d] = history[shear_ + d];

    if (advance) {
      follow_contact_plane(contact, shear);
      shear[0] -= increment * contact.vtr1;
      shear[1] -= increment * contact.vtr2;
      shear[2] -= increment * contact.vtr3;
    }
    const double limit = friction_[contact.itype][contact.jtype] * contact.Fn;
    const double size2 = shear[0] * shear[0] + shear[1] * shear[1] + shear[2] * shear[2];
    const bool sliding = size2 > limit * limit;
    if (sliding) {
      const double share = limit / std::sqrt(size2);
      for (int d = 0; d < 3; d++) shear[d] *= share;
    }
    if (advance) {
      for (int d = 0; d < 3; d++) history[shear_ + d] = shear[d];
      history[last_touch_] = step;
    }

    const double *n = contact.en;
    const double turn[3] = {n[1] * shear[2] - n[2] * shear[1], n[2] * shear[0] - n[0] * shear[2], n[0] * shear[1] - n[1] * shear[0]};
    if (ballast::ContactRecorder::active) record(contact, on_i, shear, sliding, limit, size2);
    for (int d = 0; d < 3; d++) {
      on_i.delta_F[d] += shear[d];
      on_i.delta_torque[d] -= contact.cri * turn[d];
    }
    if (contact.is_wall) return;
    for (int d = 0; d < 3; d++) {
      on_j.delta_F[d] -= shear[d];
      on_j.delta_torque[d] -= contact.crj * turn[d];
    }
  }

  void surfacesClose(SurfacesCloseData &contact, ForceData &, ForceData &) {
    if (contact.contact_flags) *contact.contact_flags = 0;
  }
  void beginPass(SurfacesIntersectData &, ForceData &, ForceData &) {}
  void endPass(SurfacesIntersectData &, ForceData &, ForceData &) {}

 private:
  /// Turn the old shear force with the contact: about the normal by the mean spin of the two bodies, then into the new contact plane,
  /// keeping its size.
  void follow_contact_plane(const SurfacesIntersectData &contact, double *shear) const {
    const double *n = contact.en, *wi = contact.omega_i, *wj = contact.omega_j;
    const double size2 = shear[0] * shear[0] + shear[1] * shear[1] + shear[2] * shear[2];
    if (size2 == 0.0) return;
    double spin = wi[0] * n[0] + wi[1] * n[1] + wi[2] * n[2];
    if (!contact.is_wall) spin += wj[0] * n[0] + wj[1] * n[1] + wj[2] * n[2];
    const double angle = 0.5 * spin * update->dt;
    const double out = shear[0] * n[0] + shear[1] * n[1] + shear[2] * n[2];
    const double turned[3] = {shear[0] - out * n[0] + angle * (n[1] * shear[2] - n[2] * shear[1]),
                              shear[1] - out * n[1] + angle * (n[2] * shear[0] - n[0] * shear[2]),
                              shear[2] - out * n[2] + angle * (n[0] * shear[1] - n[1] * shear[0])};
    const double turned2 = turned[0] * turned[0] + turned[1] * turned[1] + turned[2] * turned[2];
    if (turned2 == 0.0) return;
    const double keep_size = std::sqrt(size2 / turned2);
    for (int d = 0; d < 3; d++) shear[d] = keep_size * turned[d];
  }

  static void record(const SurfacesIntersectData &contact, const ForceData &on_i, const double *shear, bool sliding, double limit,
                     double size2) {
    ballast::Contact entry;
    entry.i = contact.i;
    entry.j = contact.is_wall ? -1 : contact.j;
    entry.overlap = contact.deltan;
    entry.normal_force = 0.0;
    for (int d = 0; d < 3; d++) {
      entry.normal[d] = contact.en[d];
      entry.normal_force += on_i.delta_F[d] * contact.en[d];
      entry.shear[d] = shear[d];
    }
    // the stored force of a sliding contact lies on the limit, within rounding
    entry.sliding = sliding || size2 >= limit * limit * (1.0 - 1e-12);
    entry.dashpot_at_limit = contact.gamman != 0.0;
    ballast::ContactRecorder::active->add(entry);
  }

  double **friction_;
  int last_touch_, shear_;
};

}  // namespace ContactModels
}  // namespace LIGGGHTS

#endif
#endif
