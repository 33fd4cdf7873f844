// A tumbling satellite that a controller of this program stops: the torque is a C++ object, handles free themselves, a
// status is an exception. Checks the energy account, what an exception in the controller becomes, and that the tumbling
// dies: exit status 1 otherwise.
#include <nutate.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <exception>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>

using vector3 = std::array<double, 3>;
using quaternion = std::array<double, 4>;

// Throws an exception with the text of a status that is a failure.
void check(int status, const std::string &message = "")
{
    if (status == NUTATE_OK) return;
    char text[128] = "";
    nutate_status_text(status, text, sizeof text);
    throw std::runtime_error(message.empty() ? text : message);
}

// A satellite with a torque tau(t, omega), and its motion.
class satellite {
public:
    using controller = std::function<vector3(double, const vector3 &)>;

    satellite(const vector3 &moments, controller control) : control_(std::move(control))
    {
        char message[256] = "";
        nutate_system *body = nullptr;
        check(nutate_system_create_moments(moments.data(), 0.0, nullptr, 0, &body, message, sizeof message), message);
        std::unique_ptr<nutate_system, void (*)(nutate_system *)> owner(body, [](nutate_system *s) { nutate_system_destroy(&s); });
        check(nutate_system_add_user_torque(body, call, this));
        nutate_stepper *stepper = nullptr;
        check(nutate_stepper_create(body, &stepper, message, sizeof message), message);
        stepper_.reset(stepper);
        set("formulation", "reduced");
    }
    // The library keeps the address of this object.
    satellite(const satellite &) = delete;
    satellite &operator=(const satellite &) = delete;

    void set(const char *key, const char *value) { check_last(nutate_stepper_set(stepper_.get(), key, value)); }
    void start(const quaternion &q, const vector3 &omega)
    {
        check_last(nutate_stepper_set_state(stepper_.get(), 0.0, q.data(), omega.data()));
    }
    void steps(double dt, std::int64_t n)
    {
        failure_ = nullptr;
        int status = nutate_stepper_steps(stepper_.get(), dt, n, nullptr);
        if (failure_) std::rethrow_exception(failure_);
        check_last(status);
    }
    vector3 omega() const
    {
        vector3 value;
        check(nutate_stepper_angular_velocity(stepper_.get(), value.data()));
        return value;
    }
    std::array<double, 5> energy()
    {
        std::array<double, 5> value;
        check_last(nutate_stepper_energy(stepper_.get(), value.data()));
        return value;
    }
    double time() const
    {
        double t;
        check(nutate_stepper_time(stepper_.get(), &t));
        return t;
    }

private:
    struct destroy {
        void operator()(nutate_stepper *stepper) const { nutate_stepper_destroy(&stepper); }
    };
    std::unique_ptr<nutate_stepper, destroy> stepper_;
    controller control_;
    std::exception_ptr failure_;

    void check_last(int status)
    {
        if (status == NUTATE_OK) return;
        char message[256] = "";
        nutate_last_message(stepper_.get(), message, sizeof message);
        check(status, message);
    }

    // No exception may cross the library: it waits here until the call is over.
    static int call(double t, const double[4], const double omega[3], void *user, double tau[3]) noexcept
    {
        satellite *self = static_cast<satellite *>(user);
        try {
            vector3 torque = self->control_(t, {{omega[0], omega[1], omega[2]}});
            for (int i = 0; i < 3; ++i) tau[i] = torque[i];
            return 0;
        } catch (...) {
            self->failure_ = std::current_exception();
            return 1;
        }
    }
};

double length(const vector3 &v) { return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

// The controller fails at 1 s: the exception comes out of `steps`, and the motion stays where it was.
bool survives_exception()
{
    satellite body({{10.0, 15.0, 20.0}}, [](double t, const vector3 &) -> vector3 {
        if (t > 1.0) throw std::domain_error("the controller gave up");
        return {{0.0, 0.0, 0.0}};
    });
    body.start({{1.0, 0.0, 0.0, 0.0}}, {{0.1, 0.2, 0.3}});
    try {
        body.steps(0.01, 1000);
    } catch (const std::domain_error &) {
        return std::fabs(body.time() - 1.0) < 1e-9;
    }
    return false;
}

int main()
{
    try {
        const double gain = 2.0; // N m s
        satellite body({{10.0, 15.0, 20.0}}, [=](double, const vector3 &omega) -> vector3 {
            return {{-gain * omega[0], -gain * omega[1], -gain * omega[2]}};
        });
        body.start({{1.0, 0.0, 0.0, 0.0}}, {{0.4, -0.3, 0.6}});
        std::printf("     t     |omega|   kinetic energy     work done\n");
        for (int i = 0; i <= 10; ++i) {
            if (i > 0) body.steps(0.05, 100);
            auto energy = body.energy();
            std::printf("%6.1f%12.2e%17.5e%14.5e\n", body.time(), length(body.omega()), energy[0], energy[3]);
        }
        auto energy = body.energy();
        bool good = std::fabs(energy[4]) < 1e-13 && length(body.omega()) < 1e-1 * 0.78 && energy[3] < -5.0 && survives_exception();
        std::printf("energy account closed to %.1e J\n", energy[4]);
        if (!good) std::fprintf(stderr, "detumble: a check failed\n");
        return good ? 0 : 1;
    } catch (const std::exception &error) {
        std::fprintf(stderr, "detumble: %s\n", error.what());
        return 1;
    }
}
