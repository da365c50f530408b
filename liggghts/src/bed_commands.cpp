// Commands that place, delete and write clumps and their contacts.
#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "atom.h"
#include "atom_vec.h"
#include "bed_state.h"
#include "comm.h"
#include "commands.h"
#include "domain.h"
#include "error.h"
#include "stop_with_error.h"
#include "fix_bonds.h"
#include "fix_multisphere.h"
#include "fix_property_atom.h"
#include "force.h"
#include "input.h"
#include "lammps.h"
#include "output_file.h"
#include "particleToInsert_multisphere.h"

using namespace LAMMPS_NS;

namespace ballast {

namespace {

const char BED_HEADER[] = "id,x_m,y_m,z_m,qw,qx,qy,qz";

struct Pose {
  int id;
  double centre[3], quaternion[4];
};

struct ClumpShape {
  double radius, half_distance, mass, density, inertia_transverse, inertia_axial;
  int type;
};

FixMultisphere *clumps_of(LAMMPS *lmp) {
  FixMultisphere *clumps = find_clumps(lmp);
  if (!clumps) stop_with_error(lmp, "no clumps: the deck needs a fix multisphere first");
  return clumps;
}

std::vector<Pose> read_bed(LAMMPS *lmp, const std::string &path) {
  std::ifstream file(path);
  if (!file) stop_with_error(lmp, path + ": cannot be read; run the stage before, or give the path of a bed file");
  std::string line;
  std::getline(file, line);
  while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
  if (line != BED_HEADER) stop_with_error(lmp, path + ": is no bed file; its first line must be " + BED_HEADER);
  std::vector<Pose> bed;
  std::set<int> ids;
  for (int number = 2; std::getline(file, line); number++) {
    if (line.find_first_not_of(" \r\t") == std::string::npos) continue;
    Pose p;
    double *q = p.quaternion;
    const int found = sscanf(line.c_str(), "%d,%lf,%lf,%lf,%lf,%lf,%lf,%lf", &p.id, p.centre, p.centre + 1,
                             p.centre + 2, q, q + 1, q + 2, q + 3);
    const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (found != 8 || p.id < 1 || !(std::fabs(norm - 1.0) < 1e-6) ||
        !std::isfinite(p.centre[0] + p.centre[1] + p.centre[2]) || !ids.insert(p.id).second) {
      std::ostringstream text;
      text << path << ": line " << number
           << " is no clump; expected a positive id that no other line has, a position and a unit quaternion";
      stop_with_error(lmp, text.str());
    }
    bed.push_back(p);
  }
  if (bed.empty()) stop_with_error(lmp, path + ": holds no clump; make the bed again");
  return bed;
}

ClumpShape read_shape(LAMMPS *lmp, int narg, char **arg) {
  std::map<std::string, double> values;
  for (int n = 1; n < narg;) {
    const std::string key = arg[n++];
    const int count = key == "inertia" ? 2 : 1;
    if (n + count > narg) stop_with_error(lmp, "place: value of " + key + " is missing");
    values[key] = lmp->force->numeric(FLERR, arg[n]);
    if (count == 2) values["inertia_axial"] = lmp->force->numeric(FLERR, arg[n + 1]);
    n += count;
  }
  for (const char *key : {"radius", "half_distance", "mass", "density", "inertia", "type"})
    if (!(values[key] > 0.0)) stop_with_error(lmp, std::string("place: ") + key + " must be given and positive");
  return {
      values["radius"],        values["half_distance"],         values["mass"], values["density"], values["inertia"],
      values["inertia_axial"], static_cast<int>(values["type"])};
}

/// Add the spheres and the rigid body of one clump to this rank.
int insert_clump(LAMMPS *lmp, const ClumpShape &shape, Pose pose) {
  ParticleToInsertMultisphere clump(lmp, 2);
  double at_rest[3] = {0.0, 0.0, 0.0};
  clump.groupbit = 1;
  clump.atom_type = shape.type;
  clump.type_ms = 1;
  clump.mass_ins = shape.mass;
  clump.density_ins = shape.density;
  clump.volume_ins = shape.mass / shape.density;
  clump.r_bound_ins = shape.half_distance + shape.radius;
  const double inertia[3] = {shape.inertia_transverse, shape.inertia_transverse, shape.inertia_axial};
  for (int d = 0; d < 3; d++) {
    clump.inertia[d] = inertia[d];
    clump.ex_space[d] = d == 0;
    clump.ey_space[d] = d == 1;
    clump.ez_space[d] = d == 2;
    clump.xcm_to_xbound[d] = clump.x_bound_ins[d] = 0.0;
  }
  for (int sphere = 0; sphere < 2; sphere++) {
    clump.displace[sphere][2] = sphere == 0 ? -shape.half_distance : shape.half_distance;
    clump.radius_ins[sphere] = shape.radius;
    clump.volumeweight[sphere] = 0.5;
  }
  clump.set_x_v_omega(pose.centre, at_rest, at_rest, pose.quaternion);
  return clump.insert();
}

/// Replace the ids LIGGGHTS gave to the new clumps of this rank by those of the bed file.
void keep_ids(LAMMPS *lmp, FixMultisphere *clumps, int first_body, const std::vector<int> &ids) {
  Multisphere &bodies = clumps->data();
  ScalarContainer<int> &body_id = *bodies.prop().getElementProperty<ScalarContainer<int>>("id_multisphere");
  std::map<int, int> renamed;
  for (std::size_t n = 0; n < ids.size(); n++) {
    renamed[body_id(first_body + n)] = ids[n];
    body_id(first_body + n) = ids[n];
  }
  int *body_of_sphere = lmp->atom->molecule;
  for (int i = 0; i < lmp->atom->nlocal; i++) {
    const std::map<int, int>::const_iterator found = renamed.find(body_of_sphere[i]);
    if (found != renamed.end()) body_of_sphere[i] = found->second;
  }
  bodies.generate_map();
}

/// Place of a clump on a space-filling curve (Morton order, cells of 1/1024 of the simulated space): its bits are those
/// of x, y, z in turn.
unsigned place_on_curve(const Domain *domain, const double *x) {
  unsigned place = 0;
  for (int d = 0; d < 3; d++) {
    const double share = (x[d] - domain->boxlo[d]) / (domain->boxhi[d] - domain->boxlo[d]);
    const unsigned cell = static_cast<unsigned>(1023.0 * std::min(1.0, std::max(0.0, share)));
    for (int bit = 0; bit < 10; bit++) place |= (cell >> bit & 1u) << (3 * bit + d);
  }
  return place;
}

bool inside_subdomain(const Domain *domain, const double *x) {
  for (int d = 0; d < 3; d++)
    if (x[d] < domain->sublo[d] || x[d] >= domain->subhi[d]) return false;
  return true;
}

/// Rows of `width` numbers of all ranks, on rank 0.
std::vector<double> gather_rows(LAMMPS *lmp, const std::vector<double> &rows) {
  const int ranks = lmp->comm->nprocs, mine = static_cast<int>(rows.size());
  std::vector<int> sizes(ranks), starts(ranks, 0);
  MPI_Gather(&mine, 1, MPI_INT, sizes.data(), 1, MPI_INT, 0, lmp->world);
  for (int r = 1; r < ranks; r++) starts[r] = starts[r - 1] + sizes[r - 1];
  std::vector<double> all(lmp->comm->me == 0 ? starts[ranks - 1] + sizes[ranks - 1] : 0);
  MPI_Gatherv(rows.data(), mine, MPI_DOUBLE, all.data(), sizes.data(), starts.data(), MPI_DOUBLE, 0, lmp->world);
  return all;
}

}  // namespace

void place(LAMMPS *lmp, int narg, char **arg) {
  if (narg < 2)
    stop_with_error(lmp, "place: expects FILE radius R half_distance H mass M density RHO inertia IT IA type T");
  FixMultisphere *clumps = clumps_of(lmp);
  if (clumps->n_body_all() > 0)
    stop_with_error(lmp, "place: there are clumps already; place them once, before the first run");
  const ClumpShape shape = read_shape(lmp, narg, arg);
  std::vector<Pose> bed = read_bed(lmp, arg[0]);
  // neighbours in space are neighbours in memory; nothing is sorted later, so that a resumed run meets the spheres in
  // the same order
  std::stable_sort(bed.begin(), bed.end(), [lmp](const Pose &a, const Pose &b) {
    return place_on_curve(lmp->domain, a.centre) < place_on_curve(lmp->domain, b.centre);
  });
  const int first_body = clumps->n_body();
  std::vector<int> ids;
  bigint spheres = 0, spheres_all;
  for (const Pose &pose : bed) {
    if (!inside_subdomain(lmp->domain, pose.centre)) continue;
    spheres += insert_clump(lmp, shape, pose);
    ids.push_back(pose.id);
  }
  MPI_Allreduce(&spheres, &spheres_all, 1, MPI_LMP_BIGINT, MPI_SUM, lmp->world);
  if (spheres_all != 2 * static_cast<bigint>(bed.size()))
    stop_with_error(lmp, std::string(arg[0]) + ": some clumps lie outside the simulated space; use a bed of this box");
  Atom *atom = lmp->atom;
  atom->tag_extend();
  atom->natoms += spheres_all;
  if (atom->map_style) {
    atom->nghost = 0;
    atom->map_init();
    atom->map_set();
  }
  clumps->add_body_finalize();
  keep_ids(lmp, clumps, first_body, ids);
  clumps->just_created = 0;  // else the first run's setup would detach all spheres from their clumps: a frozen bed
  if (lmp->comm->me == 0 && lmp->screen) fprintf(lmp->screen, "%zu clumps placed from %s\n", bed.size(), arg[0]);
}

void remove_outside(LAMMPS *lmp, int narg, char **arg) {
  if (narg != 6) stop_with_error(lmp, "remove_outside: expects XLO XHI YLO YHI ZLO ZHI");
  double box[6];
  for (int n = 0; n < 6; n++) box[n] = lmp->force->numeric(FLERR, arg[n]);
  FixMultisphere *clumps = clumps_of(lmp);
  Multisphere &bodies = clumps->data();
  const int highest = clumps->tag_max_body();
  std::vector<int> leaves(highest + 1, 0), leaves_all(highest + 1);
  for (int b = 0; b < bodies.n_body(); b++) {
    double x[3];
    bodies.xcm(x, b);
    for (int d = 0; d < 3; d++)
      if (!(x[d] >= box[2 * d] && x[d] <= box[2 * d + 1])) leaves[bodies.tag(b)] = 1;
  }
  MPI_Allreduce(leaves.data(), leaves_all.data(), highest + 1, MPI_INT, MPI_MAX, lmp->world);
  double *delete_flag = clumps->fix_delflag()->vector_atom;
  for (int i = 0; i < lmp->atom->nlocal; i++)
    if (clumps->belongs_to(i) >= 0 && leaves_all[clumps->belongs_to(i)]) delete_flag[i] = 1.0;
  if (lmp->comm->me == 0 && lmp->screen)
    fprintf(lmp->screen, "%ld clumps left the box and are deleted\n",
            static_cast<long>(std::count(leaves_all.begin(), leaves_all.end(), 1)));
  lmp->input->one("run 0 post no");  // whose setup deletes them
}

void write_bed(LAMMPS *lmp, int narg, char **arg) {
  if (narg != 1) stop_with_error(lmp, "write_bed: expects FILE");
  Multisphere &bodies = clumps_of(lmp)->data();
  std::vector<double> rows(8 * bodies.n_body());
  for (int b = 0; b < bodies.n_body(); b++) {
    rows[8 * b] = bodies.tag(b);
    bodies.xcm(&rows[8 * b + 1], b);
    bodies.quat(&rows[8 * b + 4], b);
  }
  rows = gather_rows(lmp, rows);
  if (lmp->comm->me != 0) return;
  std::vector<const double *> order;
  for (std::size_t n = 0; n < rows.size(); n += 8) order.push_back(&rows[n]);
  std::sort(order.begin(), order.end(), [](const double *a, const double *b) { return a[0] < b[0]; });
  OutputFile file(lmp, arg[0]);
  fprintf(file.stream(), "%s\n", BED_HEADER);
  for (const double *row : order) {
    fprintf(file.stream(), "%d", static_cast<int>(row[0]));
    for (int n = 1; n < 8; n++) fprintf(file.stream(), ",%.17g", row[n]);
    fprintf(file.stream(), "\n");
  }
  file.commit();
}

void write_contacts(LAMMPS *lmp, int narg, char **arg) {
  if (narg != 1) stop_with_error(lmp, "write_contacts: expects FILE");
  FixMultisphere *clumps = find_clumps(lmp);
  const Atom *atom = lmp->atom;
  auto owner = [&](int i) { return clumps ? clumps->belongs_to(i) : atom->tag[i]; };
  const int width = 12;
  std::vector<double> rows;
  for (const Contact &c : collect_contacts(lmp)) {
    const double reach = atom->radius[c.i] - 0.5 * c.overlap;
    rows.push_back(owner(c.i));
    rows.push_back(c.j < 0 ? 0 : owner(c.j));
    for (int d = 0; d < 3; d++) rows.push_back(atom->x[c.i][d] - reach * c.normal[d]);
    for (int d = 0; d < 3; d++) rows.push_back(0.0 - c.normal[d]);
    rows.push_back(c.overlap);
    rows.push_back(c.normal_force);
    rows.push_back(std::sqrt(c.shear[0] * c.shear[0] + c.shear[1] * c.shear[1] + c.shear[2] * c.shear[2]));
    rows.push_back(c.sliding);
  }
  rows = gather_rows(lmp, rows);
  if (lmp->comm->me != 0) return;
  OutputFile file(lmp, arg[0]);
  fprintf(file.stream(), "clump_1,clump_2,x_m,y_m,z_m,nx,ny,nz,overlap_m,normal_force_N,shear_force_N,sliding\n");
  for (std::size_t n = 0; n < rows.size(); n += width) {
    fprintf(file.stream(), "%d,%d", static_cast<int>(rows[n]), static_cast<int>(rows[n + 1]));
    for (int k = 2; k < width - 1; k++) fprintf(file.stream(), ",%.17g", rows[n + k]);
    fprintf(file.stream(), ",%d\n", static_cast<int>(rows[n + width - 1]));
  }
  file.commit();
}

void write_bonds(LAMMPS *lmp, int narg, char **arg) {
  if (narg != 1) stop_with_error(lmp, "write_bonds: expects FILE");
  FixBonds *bonds = FixBonds::find(lmp);
  if (!bonds) return;
  FixMultisphere *clumps = find_clumps(lmp);
  const Atom *atom = lmp->atom;
  // the clump of each sphere; those of a broken bond may be far from each other
  const int highest = lmp->atom->tag_max();
  std::vector<int> mine(highest + 1, 0), owner(highest + 1, 0);
  for (int i = 0; i < atom->nlocal; i++) mine[atom->tag[i]] = clumps ? clumps->belongs_to(i) : atom->tag[i];
  MPI_Allreduce(mine.data(), owner.data(), highest + 1, MPI_INT, MPI_MAX, lmp->world);
  const int width = 10;
  std::vector<double> rows;
  for (const FixBonds::Row &row : bonds->rows()) {
    rows.push_back(owner[atom->tag[row.i]]);
    rows.push_back(owner[static_cast<int>(row.bond.partner)]);
    rows.insert(rows.end(), row.place, row.place + 3);
    rows.push_back(row.bond.fate != HOLDS);
    rows.push_back(row.bond.broken_step);
    rows.push_back(row.bond.fate);
    rows.push_back(row.tensile_stress);
    rows.push_back(row.shear_stress);
  }
  rows = gather_rows(lmp, rows);
  if (lmp->comm->me != 0) return;
  const char *const modes[] = {"", "tension", "shear"};
  OutputFile file(lmp, arg[0]);
  fprintf(file.stream(), "clump_1,clump_2,x_m,y_m,z_m,broken,step,mode,tensile_stress_Pa,shear_stress_Pa\n");
  for (std::size_t n = 0; n < rows.size(); n += width) {
    const double *row = &rows[n];
    fprintf(file.stream(), "%.0f,%.0f,%.17g,%.17g,%.17g,%.0f,%.0f,%s,%.17g,%.17g\n", row[0], row[1], row[2], row[3],
            row[4], row[5], row[6], modes[static_cast<int>(row[7])], row[8], row[9]);
  }
  file.commit();
}

}  // namespace ballast
