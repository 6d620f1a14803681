// Sends images to the engine (`camera`), or receives them (`screen`), and reports the processor time that it has used.
#include <ctime>

#include "asmotion.hpp"

struct Image {
    static constexpr const char* message_name = "acme/Image";
    std::vector<std::uint8_t> data{};
    template <class V>
    static void fields(V&& visit) {
        visit("data", &Image::data, "");
    }
};

/// Processor time of this process, ns.
static std::int64_t used() {
    timespec time{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return static_cast<std::int64_t>(time.tv_sec) * 1'000'000'000 + time.tv_nsec;
}

class Camera : public asmotion::Component {
    asmotion::Out<Image> image{this, "image"};
    Image next;

public:
    Camera() { next.data.resize(size); }
    void update(asmotion::Cycle& cycle) override {
        if (!next.data.empty()) next.data[0]++;
        image.write(next);
        cycle.report("used", used());
    }
    static std::size_t size;
};
std::size_t Camera::size = 0;

class Screen : public asmotion::Component {
    asmotion::In<Image> image{this, "image"};
    void update(asmotion::Cycle& cycle) override { cycle.report("used", used()); }
};

int main(int count, char** arguments) {
    if (count < 3) return 2;
    Camera::size = std::strtoul(arguments[2], nullptr, 10);
    return std::string(arguments[1]) == "camera" ? asmotion::run<Camera>() : asmotion::run<Screen>();
}
