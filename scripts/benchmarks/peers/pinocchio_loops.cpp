/* Pinocchio's C++ in loops over states, headers alone: an arm by placements and inertial parameters of its joints. */
#include <pinocchio/multibody.hpp>
#include <pinocchio/algorithm/model.hpp>
#include <pinocchio/algorithm/rnea.hpp>
#include <pinocchio/algorithm/crba.hpp>
#include <pinocchio/algorithm/aba.hpp>
namespace {
pinocchio::Model model;
pinocchio::Data *data = nullptr;
typedef Eigen::Map<const Eigen::VectorXd> In;
typedef Eigen::Map<Eigen::VectorXd> Out;
}
extern "C" void load(int n, const double *placement, const double *inertia, const double *armature, const double *gravity)
{
    typedef Eigen::Map<const Eigen::Matrix<double, 10, 1>> Parameters;
    model = pinocchio::Model();
    delete data;
    for (int i = 0; i < n; i++, placement += 12, inertia += 10) {
        const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> R(placement);
        const pinocchio::SE3 at(R, Eigen::Vector3d(placement[9], placement[10], placement[11]));
        const auto joint = model.addJoint(i, pinocchio::JointModelRZ(), at, std::to_string(i));
        model.appendBodyToJoint(joint, pinocchio::Inertia::FromDynamicParameters(Parameters(inertia)));
        model.armature[i] = armature[i];
    }
    model.gravity.linear() = Eigen::Vector3d(gravity[0], gravity[1], gravity[2]);
    data = new pinocchio::Data(model);
}
extern "C" void peer_rnea(const double *x, double *out, long m, long last)
{
    const int n = model.nv;
    for (long i = 0; i < m; i++) {
        const double *p = x + (i & last) * 3 * n;
        Out(out, n) = pinocchio::rnea(model, *data, In(p, n), In(p + n, n), In(p + 2 * n, n));
    }
}
extern "C" void peer_aba(const double *x, double *out, long m, long last)
{
    const int n = model.nv;
    for (long i = 0; i < m; i++) {
        const double *p = x + (i & last) * 3 * n;
        Out(out, n) = pinocchio::aba(model, *data, In(p, n), In(p + n, n), In(p + 2 * n, n));
    }
}
extern "C" void peer_crba(const double *x, double *out, long m, long last)
{
    const int n = model.nv;
    for (long i = 0; i < m; i++)
        Eigen::Map<Eigen::MatrixXd>(out, n, n) = pinocchio::crba(model, *data, In(x + (i & last) * n, n));
}
