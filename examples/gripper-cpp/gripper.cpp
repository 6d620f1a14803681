// A gripper: moves to the commanded opening, and closes on request after it has asked whether it may.
#include <algorithm>
#include <deque>

#include "asmotion.hpp"
#include "messages.hpp"

using acme::Grip, acme::Guard;

class Gripper : public asmotion::Component {
    asmotion::In<acme::GripperCommand> command{this, "command", "wanted opening"};
    asmotion::Out<acme::GripperState> state_out{this, "state", "where the fingers are", acme::GripperState{0.1, false}};
    asmotion::Service<Grip> grip{this, "grip", "closes the fingers"};
    asmotion::Reference<Guard> guard{this, "guard", "asked before the fingers close", asmotion::optional};
    asmotion::Property<double> speed{this, "speed", 0.1, "of the fingers", asmotion::unit("m/s"), asmotion::range(0.01, 0.5)};
    asmotion::Property<std::string> mode{this, "mode", "soft", "of the controller", asmotion::choices({"soft", "hard"})};
    double opening = 0.0, target = 0.0;
    std::deque<std::pair<asmotion::Call<acme::Permission>, asmotion::Reply<acme::Closed>>> asked;

public:
    Gripper() {
        grip.on<Grip::close>(
            [this](const acme::Close& request, asmotion::Reply<acme::Closed> reply) {
                if (!cycle().is_running()) throw asmotion::Fault("STOPPED", "start me first");
                asked.emplace_back(guard.call<Guard::ask>(request), reply);
            },
            asmotion::while_stopped);
    }

    void configure() override { std::cout << "configured with " << speed << std::endl; }

    void update(asmotion::Cycle& cycle) override {
        for (const acme::GripperCommand& sample : command.all()) target = sample.opening;
        while (!asked.empty() && asked.front().first.is_done()) {
            answer(asked.front().first, asked.front().second);
            asked.pop_front();
        }
        const double step = speed * 0.1;
        opening = std::min(std::max(target, opening - step), opening + step);
        state_out.write({opening, opening == 0.0});
        cycle.report("opening", opening);
    }

    void inspect(asmotion::Inspection& show) override {
        show("opening", opening);
        show("target", target);
    }

    void state(asmotion::State& state) override { state(opening)(target)(asked); }

private:
    void answer(const asmotion::Call<acme::Permission>& call, const asmotion::Reply<acme::Closed>& reply) {
        try {
            if (!call.result().granted) return reply.refuse("REFUSED", "the guard says no");
        } catch (const asmotion::CallError& error) {
            // without a guard it may
            if (error.kind != "unavailable") return reply.refuse("NO_GUARD", error.kind);
        }
        target = 0.0;
        reply({opening});
    }
};

int main() { return asmotion::run<Gripper>("acme-gripper-cpp 1.0"); }
