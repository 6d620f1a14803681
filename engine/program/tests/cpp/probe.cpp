// Components in C++ that use all of the protocol, or go wrong: the first argument says which.
#include <atomic>
#include <thread>

#include "asmotion.hpp"

struct Inner {
    std::int16_t count{7};
    std::optional<std::string> name{};
    template <class V> static void fields(V&& visit) {
        visit("count", &Inner::count, "of parts");
        visit("name", &Inner::name, "");
    }
};

struct Everything {
    static constexpr const char* message_name = "acme/Everything";
    bool yes{true};
    std::uint8_t u8{};
    std::int32_t i32{};
    std::int64_t i64{std::numeric_limits<std::int64_t>::min()};
    std::uint64_t u64{};
    float f32{};
    double f64{1.5};
    std::string text{};
    std::optional<double> maybe{};
    std::vector<std::uint8_t> bytes{};
    std::vector<float> floats{};
    std::vector<std::uint64_t> longs{};
    std::vector<bool> flags{};
    std::vector<std::string> words{};
    std::array<double, 3> three{1.0, 2.0, 3.0};
    Inner inner{};
    std::vector<Inner> inners{};
    std::any any{};
    template <class V> static void fields(V&& visit) {
        visit("yes", &Everything::yes, "");
        visit("u8", &Everything::u8, "");
        visit("i32", &Everything::i32, "");
        visit("i64", &Everything::i64, "");
        visit("u64", &Everything::u64, "");
        visit("f32", &Everything::f32, "");
        visit("f64", &Everything::f64, "");
        visit("text", &Everything::text, "");
        visit("maybe", &Everything::maybe, "");
        visit("bytes", &Everything::bytes, "");
        visit("floats", &Everything::floats, "");
        visit("longs", &Everything::longs, "");
        visit("flags", &Everything::flags, "");
        visit("words", &Everything::words, "");
        visit("three", &Everything::three, "");
        visit("inner", &Everything::inner, "");
        visit("inners", &Everything::inners, "");
        visit("any", &Everything::any, "");
    }
};

struct Number {
    static constexpr const char* message_name = "acme/Number";
    std::int64_t n{};
    template <class V> static void fields(V&& visit) { visit("n", &Number::n, ""); }
};

class Echo : public asmotion::Component {
    asmotion::In<Everything> in{this, "in", "any sample"};
    asmotion::In<Number> target{this, "target", "where to go", asmotion::command};
    asmotion::Out<Everything> out{this, "out", "the same sample"};
    void update(asmotion::Cycle&) override {
        for (const Everything& sample : in.all()) out.write(sample);
    }
};

struct Counting {
    static constexpr const char* interface_name = "acme/Counting";
    struct add {
        static constexpr const char* operation_name = "add";
        using request = Number;
        using response = Number;
    };
    template <class V> static void operations(V&& visit) { visit(add{}); }
};

struct Jammed : asmotion::Fault {
    Jammed() : Fault("JAMMED", "the fingers are stuck") {}
};

/// One effect in each cycle; its service adds, and its reference calls it.
class Effects : public asmotion::Component {
    asmotion::Service<Counting> service{this, "service", "adds"};
    asmotion::Reference<Counting> peer{this, "peer", "adds too"};
    asmotion::Property<std::int64_t> first{this, "first", 1, "number", asmotion::unit("m"), asmotion::range(0, 9)};
    std::int64_t sum = 0;
    asmotion::Call<Number> call;

public:
    Effects() {
        service.on<Counting::add>([this](const Number& request) {
            if (request.n > 5) throw asmotion::Fault("TOO_MANY", "more than five");
            sum += request.n;
            return Number{sum};
        });
    }
    void configure() override { std::cout << "configured with " << first << std::endl; }
    void start() override { std::cout << "started" << std::endl; }
    void stop(asmotion::Cycle& cycle) override { cycle.report("sum", sum); }
    void recover(asmotion::Cycle& cycle) override { cycle.report("recovers", cycle.number()); }
    void update(asmotion::Cycle& cycle) override {
        if (call.is_done()) end(cycle);
        switch (cycle.number()) {
        case 1: cycle.set_period(std::chrono::milliseconds(50)); break;
        case 2: cycle.set_duration(std::chrono::milliseconds(20)); break;
        case 3: peer.notify<Counting::add>({2}); break;
        case 4: call = peer.call<Counting::add>({3}); break;
        case 6: call = peer.call<Counting::add>({8}); break;
        case 8: call = peer.call<Counting::add>({1}); call.cancel(); break;
        case 10: cycle.error("WORN", "the brushes are worn"); break;
        default: cycle.report("at", cycle.now().count());
        }
    }

private:
    void end(asmotion::Cycle& cycle) {
        try {
            cycle.report("sum", call.result());
        } catch (const asmotion::CallError& error) {
            cycle.report("error", error.what());
        }
        call = {};
    }
};

class Failing : public asmotion::Component {
    void update(asmotion::Cycle& cycle) override {
        if (cycle.number() == 2 && how == "faults") throw Jammed();
        if (cycle.number() == 2 && how == "throws") throw std::out_of_range("no such finger");
        if (cycle.number() == 2 && how == "again") cycle.again();
        if (cycle.number() == 2 && how == "ends") std::exit(3);
    }

public:
    static std::string how;
};
std::string Failing::how;

/// Requests cycles from a thread of its own.
class Waking : public asmotion::Component {
    std::thread thread;
    std::atomic<bool> is_to_end{false};
    void start() override {
        if (is_virtual()) return;
        thread = std::thread([this] {
            while (!is_to_end) {
                std::this_thread::sleep_for(std::chrono::milliseconds(50));
                wake();
            }
        });
    }
    void update(asmotion::Cycle& cycle) override { cycle.report("awake", cycle.number()); }

public:
    ~Waking() override {
        is_to_end = true;
        if (thread.joinable()) thread.join();
    }
};

/// Requests each of its cycles at a time.
class Ticking : public asmotion::Component {
    void update(asmotion::Cycle& cycle) override {
        cycle.report("now", cycle.now().count());
        cycle.again_at(cycle.now() + std::chrono::milliseconds(500));
        cycle.again_at(cycle.now() + std::chrono::milliseconds(70));
        cycle.again_at(cycle.now() + std::chrono::milliseconds(90));
    }
};

int main(int count, char** arguments) {
    Failing::how = count > 1 ? arguments[1] : "";
    if (Failing::how == "echo") return asmotion::run<Echo>();
    if (Failing::how == "effects") return asmotion::run<Effects>("probe 1.0");
    if (Failing::how == "wakes") return asmotion::run<Waking>();
    if (Failing::how == "ticks") return asmotion::run<Ticking>();
    return asmotion::run<Failing>();
}
