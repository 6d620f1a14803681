// asmotion: components in C++17, in a program of their own (README.md). Header-only, Linux, without dependencies.
#ifndef ASMOTION_HPP
#define ASMOTION_HPP

#include <any>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <exception>
#include <functional>
#include <iostream>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "asmotion.h"

namespace asmotion {

/// A fault of the component, or of an operation for its caller. The code is a word in capitals, and may be empty.
class Fault : public std::runtime_error {
public:
    Fault(std::string code, const std::string& text) : std::runtime_error(text), code(std::move(code)) {}
    std::string code;
};

/// Data that do not fit the type that is read.
class Misfit : public Fault {
public:
    explicit Misfit(const std::string& text) : Fault("PROTOCOL", text) {}
};

/// The end of a call without a result.
class CallError : public std::runtime_error {
public:
    CallError(std::string kind, std::string code, const std::string& text)
        : std::runtime_error(code.empty() ? kind : kind + " " + code + ": " + text),
          kind(std::move(kind)), code(std::move(code)), text(text) {}
    /// `timeout`, `unavailable`, `stopped`, `cancelled` or `fault`.
    std::string kind;
    /// Code and text of a fault.
    std::string code, text;
};

/// The record of an `any`: names and values in their order.
using AnyRecord = std::vector<std::pair<std::string, std::any>>;
/// The list of an `any`.
using AnyList = std::vector<std::any>;
using Bytes = std::vector<std::uint8_t>;

class Component;

// ---- Data -----------------------------------------------------------------------------------------------------------

namespace detail {

struct AnyVisitor {
    template <class... Arguments>
    void operator()(Arguments&&...) const {}
};

template <class T, class = void>
struct IsRecord : std::false_type {};
template <class T>
struct IsRecord<T, std::void_t<decltype(T::fields(std::declval<AnyVisitor&>()))>> : std::true_type {};

template <class T, class = void>
struct HasName : std::false_type {};
template <class T>
struct HasName<T, std::void_t<decltype(T::message_name)>> : std::true_type {};

template <class T>
constexpr bool is_number = std::is_arithmetic_v<T> && !std::is_same_v<T, bool>;

/// The element type of lists that are packed; 0 for others.
template <class T>
constexpr int element() {
    if constexpr (std::is_same_v<T, double>) return ASMOTION_F64;
    else if constexpr (std::is_same_v<T, float>) return ASMOTION_F32;
    else if constexpr (!is_number<T> || std::is_floating_point_v<T> || (std::is_unsigned_v<T> && sizeof(T) == 8)) return 0;
    else if constexpr (std::is_signed_v<T>) return sizeof(T) == 1 ? 72 : sizeof(T) == 2 ? 77 : sizeof(T) == 4 ? 78 : 79;
    else return sizeof(T) == 1 ? 64 : sizeof(T) == 2 ? 69 : 70;
}

[[noreturn]] inline void misfit(const std::string& wanted) { throw Misfit("expected " + wanted); }

/// Puts a place before the text of a misfit.
template <class Read>
void at(const char* kind, const std::string& name, Read&& read) {
    try {
        read();
    } catch (const Misfit& error) {
        throw Misfit(std::string(kind) + " `" + name + "`: " + error.what());
    }
}

inline std::string text(asmotion_value value) {
    asmotion_bytes bytes = {nullptr, 0};
    if (!asmotion_read_text(value, &bytes)) misfit("a text");
    return std::string(reinterpret_cast<const char*>(bytes.data), bytes.size);
}

inline std::int64_t integer(asmotion_value value) {
    std::int64_t found = 0;
    if (!asmotion_read_int(value, &found)) misfit("an integer");
    return found;
}

template <class T>
T narrow(std::int64_t value) {
    bool fits = std::is_signed_v<T> || value >= 0;
    if constexpr (sizeof(T) < 8) {
        fits = value >= static_cast<std::int64_t>(std::numeric_limits<T>::min()) &&
               value <= static_cast<std::int64_t>(std::numeric_limits<T>::max());
    }
    if (!fits) throw Misfit(std::to_string(value) + " is out of range");
    return static_cast<T>(value);
}

template <class Each>
void each(asmotion_value list, Each&& visit) {
    asmotion_value key = {nullptr, list.in}, part = {nullptr, list.in};
    asmotion_iterator parts = asmotion_iterate(list);
    while (asmotion_next(&parts, &key, &part)) visit(key, part);
}

inline void write(asmotion_writer* to, const std::string& text) { asmotion_write_string(to, text.data(), text.size()); }

inline void entry(asmotion_writer* to, const char* key, const std::string& value) {
    asmotion_write_text(to, key);
    write(to, value);
}

/// A writer without shared memory, which frees its bytes.
struct Buffer : asmotion_writer {
    Buffer() : asmotion_writer() {}
    Buffer(const Buffer&) = delete;
    Buffer& operator=(const Buffer&) = delete;
    ~Buffer() { asmotion_free(this); }
    bool is_same_as(const Buffer& other) const {
        return size == other.size && (size == 0 || std::memcmp(bytes, other.bytes, size) == 0);
    }
};

}  // namespace detail

/// The form of a C++ type as data: `shape` writes its shape, `write` a value, `read` returns one or throws `Misfit`.
template <class T, class = void>
struct Form;

/// Writes a value as data.
template <class T>
void write(asmotion_writer* to, const T& value) {
    Form<T>::write(to, value);
}

/// Reads a value from data. Throws `Misfit`.
template <class T>
T read(asmotion_value value) {
    return Form<T>::read(value);
}

/// Writes the schema of a type.
template <class T>
void write_schema(asmotion_writer* to) {
    asmotion_write_map(to);
    if constexpr (detail::HasName<T>::value) asmotion_write_entry(to, "name", T::message_name);
    asmotion_write_text(to, "shape");
    Form<T>::shape(to);
    asmotion_write_end(to);
}

template <>
struct Form<bool> {
    static void shape(asmotion_writer* to) { asmotion_write_text(to, "bool"); }
    static void write(asmotion_writer* to, bool value) { asmotion_write_bool(to, value); }
    static bool read(asmotion_value value) {
        bool found = false;
        if (!asmotion_read_bool(value, &found)) detail::misfit("a Boolean");
        return found;
    }
};

template <class T>
struct Form<T, std::enable_if_t<std::is_integral_v<T> && !std::is_same_v<T, bool>>> {
    static void shape(asmotion_writer* to) {
        detail::write(to, (std::is_signed_v<T> ? "i" : "u") + std::to_string(8 * sizeof(T)));
    }
    static void write(asmotion_writer* to, T value) {
        if constexpr (std::is_signed_v<T>) asmotion_write_int(to, value);
        else asmotion_write_unsigned(to, value);
    }
    static T read(asmotion_value value) { return detail::narrow<T>(detail::integer(value)); }
};

template <class T>
struct Form<T, std::enable_if_t<std::is_floating_point_v<T>>> {
    static_assert(sizeof(T) <= 8, "messages have floats of 32 and 64 bits");
    static void shape(asmotion_writer* to) { asmotion_write_text(to, sizeof(T) == 4 ? "f32" : "f64"); }
    static void write(asmotion_writer* to, T value) { asmotion_write_float(to, static_cast<double>(value)); }
    static T read(asmotion_value value) {
        double found = 0;
        if (!asmotion_read_float(value, &found)) detail::misfit("a number");
        return static_cast<T>(found);
    }
};

template <>
struct Form<std::string> {
    static void shape(asmotion_writer* to) { asmotion_write_text(to, "text"); }
    static void write(asmotion_writer* to, const std::string& value) { detail::write(to, value); }
    static std::string read(asmotion_value value) { return detail::text(value); }
};

template <class T>
struct Form<std::optional<T>> {
    static void shape(asmotion_writer* to) {
        asmotion_write_map(to);
        asmotion_write_text(to, "option");
        write_schema<T>(to);
        asmotion_write_end(to);
    }
    static void write(asmotion_writer* to, const std::optional<T>& value) {
        if (value) Form<T>::write(to, *value);
        else asmotion_write_null(to);
    }
    static std::optional<T> read(asmotion_value value) {
        if (asmotion_kind_of(value) == ASMOTION_NULL) return std::nullopt;
        return Form<T>::read(value);
    }
};

namespace detail {

template <class List>
void write_list(asmotion_writer* to, const List& list) {
    using T = typename List::value_type;
    if constexpr (element<T>() != 0) {
        asmotion_write_numbers(to, static_cast<asmotion_element>(element<T>()), list.data(), list.size());
    } else {
        asmotion_write_list(to);
        for (const auto& part : list) Form<T>::write(to, part);
        asmotion_write_end(to);
    }
}

/// Calls `add` with each element, or copies all of them at once to the result of `space` for a count.
template <class T, class Space, class Add>
void read_list(asmotion_value value, Space&& space, Add&& add) {
    asmotion_numbers numbers;
    if (asmotion_read_numbers(value, &numbers)) {
        if constexpr (is_number<T>) {
            constexpr bool is_little = __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__ || sizeof(T) == 1;
            if (is_little && static_cast<int>(numbers.element) == element<T>()) {
                T* place = space(numbers.count);
                if (numbers.count > 0) std::memcpy(static_cast<void*>(place), numbers.data, numbers.count * sizeof(T));
                return;
            }
            for (std::size_t index = 0; index < numbers.count; index++) {
                std::int64_t whole = 0;
                double real = 0;
                bool is_float = asmotion_number_at(numbers, index, &whole, &real);
                if constexpr (std::is_floating_point_v<T>) add(static_cast<T>(is_float ? real : static_cast<double>(whole)));
                else if (is_float) misfit("integers");
                else add(narrow<T>(whole));
            }
            return;
        }
        misfit("a list");
    }
    if (asmotion_kind_of(value) != ASMOTION_LIST) misfit("a list");
    each(value, [&](asmotion_value, asmotion_value part) { add(Form<T>::read(part)); });
}

}  // namespace detail

template <class T>
struct Form<std::vector<T>> {
    static void shape(asmotion_writer* to) {
        asmotion_write_map(to);
        asmotion_write_text(to, "list");
        write_schema<T>(to);
        asmotion_write_end(to);
    }
    static void write(asmotion_writer* to, const std::vector<T>& value) { detail::write_list(to, value); }
    static std::vector<T> read(asmotion_value value) {
        std::vector<T> list;
        auto space = [&](std::size_t count) {
            list.resize(count);
            if constexpr (std::is_same_v<T, bool>) return static_cast<T*>(nullptr);
            else return list.data();
        };
        detail::read_list<T>(value, space, [&](T&& part) { list.push_back(std::move(part)); });
        return list;
    }
};

template <class T, std::size_t Count>
struct Form<std::array<T, Count>> {
    static void shape(asmotion_writer* to) {
        asmotion_write_map(to);
        asmotion_write_text(to, "array");
        asmotion_write_list(to);
        write_schema<T>(to);
        asmotion_write_unsigned(to, Count);
        asmotion_write_end(to);
        asmotion_write_end(to);
    }
    static void write(asmotion_writer* to, const std::array<T, Count>& value) { detail::write_list(to, value); }
    static std::array<T, Count> read(asmotion_value value) {
        std::array<T, Count> array{};
        std::size_t filled = 0;
        auto space = [&](std::size_t count) {
            if (count != Count) detail::misfit(std::to_string(Count) + " elements");
            filled = count;
            return array.data();
        };
        auto add = [&](T&& part) {
            if (filled == Count) detail::misfit(std::to_string(Count) + " elements");
            array[filled++] = std::move(part);
        };
        detail::read_list<T>(value, space, add);
        if (filled != Count) detail::misfit(std::to_string(Count) + " elements");
        return array;
    }
};

/// A record: a type with a static function `fields`, as `asmotion describe --cpp` writes it.
template <class T>
struct Form<T, std::enable_if_t<detail::IsRecord<T>::value>> {
    static void shape(asmotion_writer* to) {
        const T initial{};
        asmotion_write_map(to);
        asmotion_write_text(to, "record");
        asmotion_write_list(to);
        T::fields([&](const char* name, auto member, const char* doc) { field(to, initial, name, member, doc); });
        asmotion_write_end(to);
        asmotion_write_end(to);
    }
    static void write(asmotion_writer* to, const T& value) {
        asmotion_write_map(to);
        T::fields([&](const char* name, auto member, const char*) {
            asmotion_write_text(to, name);
            asmotion::write(to, value.*member);
        });
        asmotion_write_end(to);
    }
    static T read(asmotion_value value) {
        if (asmotion_kind_of(value) != ASMOTION_MAP) detail::misfit("a record");
        T record{};
        T::fields([&](const char* name, auto member, const char*) {
            asmotion_value found = asmotion_get(value, name);
            if (asmotion_is_absent(found)) return;
            detail::at("field", name, [&] {
                record.*member = asmotion::read<std::decay_t<decltype(record.*member)>>(found);
            });
        });
        return record;
    }

private:
    template <class M>
    static void field(asmotion_writer* to, const T& initial, const char* name, M T::*member, const char* doc) {
        detail::Buffer given, zero;
        asmotion::write(&given, initial.*member);
        asmotion::write(&zero, M{});
        asmotion_write_map(to);
        asmotion_write_entry(to, "name", name);
        asmotion_write_entry(to, "doc", doc);
        asmotion_write_text(to, "schema");
        write_schema<M>(to);
        if (!given.is_same_as(zero)) {
            asmotion_write_text(to, "initial");
            asmotion::write(to, initial.*member);
        }
        asmotion_write_end(to);
    }
};

/// Any data: empty, `bool`, `std::int64_t`, `double`, `std::string`, `Bytes`, `AnyList` or `AnyRecord`.
template <>
struct Form<std::any> {
    static void shape(asmotion_writer* to) { asmotion_write_text(to, "any"); }
    static void write(asmotion_writer* to, const std::any& value) {
        bool is_known = !value.has_value() || write_as<bool>(to, value) || write_as<std::int64_t>(to, value) ||
                        write_as<double>(to, value) || write_as<std::string>(to, value) || write_as<Bytes>(to, value);
        if (!value.has_value()) {
            asmotion_write_null(to);
        } else if (const auto* list = std::any_cast<AnyList>(&value)) {
            asmotion_write_list(to);
            for (const std::any& part : *list) write(to, part);
            asmotion_write_end(to);
        } else if (const auto* record = std::any_cast<AnyRecord>(&value)) {
            asmotion_write_map(to);
            for (const auto& [name, part] : *record) {
                detail::write(to, name);
                write(to, part);
            }
            asmotion_write_end(to);
        } else if (!is_known) {
            throw Misfit("an `any` has a type without a form as data");
        }
    }
    static std::any read(asmotion_value value) {
        switch (asmotion_kind_of(value)) {
        case ASMOTION_NULL: return {};
        case ASMOTION_BOOL: return Form<bool>::read(value);
        case ASMOTION_INT: return detail::integer(value);
        case ASMOTION_FLOAT: return Form<double>::read(value);
        case ASMOTION_TEXT: return detail::text(value);
        case ASMOTION_BYTES: return Form<Bytes>::read(value);
        case ASMOTION_NUMBERS: return numbers(value);
        case ASMOTION_LIST: {
            AnyList list;
            detail::each(value, [&](asmotion_value, asmotion_value part) { list.push_back(read(part)); });
            return list;
        }
        case ASMOTION_MAP: {
            AnyRecord record;
            detail::each(value, [&](asmotion_value key, asmotion_value part) {
                record.emplace_back(detail::text(key), read(part));
            });
            return record;
        }
        }
        return {};
    }

private:
    template <class T>
    static bool write_as(asmotion_writer* to, const std::any& value) {
        const T* found = std::any_cast<T>(&value);
        if (found != nullptr) Form<T>::write(to, *found);
        return found != nullptr;
    }
    static std::any numbers(asmotion_value value) {
        asmotion_numbers numbers = {ASMOTION_U8, nullptr, 0};
        asmotion_read_numbers(value, &numbers);
        AnyList list;
        for (std::size_t index = 0; index < numbers.count; index++) {
            std::int64_t whole = 0;
            double real = 0;
            if (asmotion_number_at(numbers, index, &whole, &real)) list.emplace_back(real);
            else list.emplace_back(whole);
        }
        return list;
    }
};

namespace detail {

/// Whether a type has a form as data.
template <class T, class = void>
struct HasForm : std::bool_constant<std::is_arithmetic_v<T> || IsRecord<T>::value || std::is_same_v<T, std::string> ||
                                    std::is_same_v<T, std::any>> {};
template <class T>
struct HasForm<std::vector<T>> : HasForm<T> {};
template <class T>
struct HasForm<std::optional<T>> : HasForm<T> {};
template <class T, std::size_t Count>
struct HasForm<std::array<T, Count>> : HasForm<T> {};

}  // namespace detail

// ---- The cycle ------------------------------------------------------------------------------------------------------

namespace detail {

/// What a cycle asks of the engine. The lists are written one after the other and share the memory for large data.
struct Effects {
    Buffer outputs, calls, cancel, replies, reports;
    bool again = false;
    std::optional<std::int64_t> at, period, duration;
    std::optional<Fault> error;
    std::uint8_t* shared = nullptr;
    std::size_t shared_size = 0, shared_used = 0;

    void clear() {
        for (Buffer* list : {&outputs, &calls, &cancel, &replies, &reports}) {
            list->size = 0;
            list->is_failed = false;
        }
        again = false;
        at = period = duration = std::nullopt;
        error = std::nullopt;
        shared_used = 0;
    }
    /// Adds an element to a list.
    template <class Write>
    void add(Buffer& list, Write&& write) {
        const std::size_t before = list.size, used = shared_used;
        list.shared = shared;
        list.shared_size = shared_size;
        list.shared_used = shared_used;
        try {
            write(static_cast<asmotion_writer*>(&list));
        } catch (...) {
            list.size = before;
            shared_used = used;
            throw;
        }
        shared_used = list.shared_used;
        if (list.is_failed) throw std::bad_alloc();
    }
};

}  // namespace detail

/// The cycle that is being computed.
class Cycle {
public:
    /// Time of the cycle on the engine's clock.
    std::chrono::nanoseconds now() const { return std::chrono::nanoseconds(now_); }
    double seconds() const { return static_cast<double>(now_) * 1e-9; }
    std::int64_t number() const { return number_; }
    /// `false` while a stopped component serves requests.
    bool is_running() const { return is_running_; }
    /// Reports a value to observers; the kind `log` is a line of the log.
    template <class T>
    void report(const std::string& kind, const T& value) {
        effects_->add(effects_->reports, [&](asmotion_writer* to) {
            asmotion_write_list(to);
            detail::write(to, kind);
            if constexpr (std::is_convertible_v<T, const char*>) asmotion_write_text(to, value);
            else asmotion::write(to, value);
            asmotion_write_end(to);
        });
    }
    /// Requests another cycle at once; for event-driven components.
    void again() { effects_->again = true; }
    /// Requests a cycle at this time, at once if it has passed; for event-driven components. The earliest of several requests
    /// counts. A request ends with the next cycle, whatever triggers it.
    void again_at(std::chrono::nanoseconds time) {
        effects_->at = std::min(time.count(), effects_->at.value_or(time.count()));
    }
    void set_period(std::chrono::nanoseconds period) { effects_->period = period.count(); }
    /// Duration of this cycle in simulated time.
    void set_duration(std::chrono::nanoseconds duration) { effects_->duration = duration.count(); }
    /// Puts the component into the state RunTimeError after this cycle, which is sent.
    void error(const std::string& code, const std::string& text) { effects_->error = Fault(code, text); }

private:
    friend class Component;
    friend class Program;
    std::int64_t now_ = 0, number_ = 0;
    bool is_running_ = true;
    detail::Effects* effects_ = nullptr;
};

// ---- Parts of a component -------------------------------------------------------------------------------------------

namespace detail {

struct CallBase {
    std::int64_t id = 0;
    bool is_done = false;
    std::optional<CallError> error;
    virtual ~CallBase() = default;
    virtual void finish(asmotion_value result) = 0;
};

template <class Response>
struct CallState : CallBase {
    std::optional<Response> result;
    void finish(asmotion_value value) override { result = asmotion::read<Response>(value); }
};

struct InputBase {
    std::string name, doc;
    bool is_command = false;
    virtual ~InputBase() = default;
    virtual void schema(asmotion_writer* to) const = 0;
    /// Begins a cycle with the samples that have arrived; absent without any.
    virtual void arrive(asmotion_value input) = 0;
    virtual void freeze(asmotion_writer* to) const = 0;
    virtual void thaw(asmotion_value state) = 0;
    bool is_stale = false;
    std::int64_t lost = 0;
};

struct OutputBase {
    std::string name, doc;
    virtual ~OutputBase() = default;
    virtual void schema(asmotion_writer* to) const = 0;
    virtual bool write_safe(asmotion_writer* to) const = 0;
};

struct PropertyBase {
    std::string name, doc, unit_text;
    virtual ~PropertyBase() = default;
    virtual void schema(asmotion_writer* to) const = 0;
    /// Writes the default, the range and the choices.
    virtual void values(asmotion_writer* to) const = 0;
    virtual void set(asmotion_value value) = 0;
};

struct Asked {
    std::int64_t id = 0;
    std::string caller;
    std::optional<std::int64_t> deadline;
};

struct Served {
    std::string name;
    bool while_stopped = false;
    void (*request)(asmotion_writer*) = nullptr;
    void (*response)(asmotion_writer*) = nullptr;
    std::function<void(asmotion_value, const Asked&)> handle;
};

struct ServiceBase {
    std::string name, doc, interface;
    std::vector<Served> operations;
};

struct ReferenceBase {
    std::string name, doc, interface;
    bool is_optional = false;
    void (*operations)(asmotion_writer*) = nullptr;
};

template <class Operation>
void write_operation(asmotion_writer* to, bool while_stopped) {
    asmotion_write_map(to);
    asmotion_write_entry(to, "name", Operation::operation_name);
    asmotion_write_text(to, "request");
    write_schema<typename Operation::request>(to);
    asmotion_write_text(to, "response");
    write_schema<typename Operation::response>(to);
    if (while_stopped) {
        asmotion_write_text(to, "while_stopped");
        asmotion_write_bool(to, true);
    }
    asmotion_write_end(to);
}

}  // namespace detail

class State;

/// Fields that `inspect` shows.
class Inspection {
public:
    template <class T>
    void operator()(const std::string& name, const T& value) {
        asmotion_write_list(to_);
        detail::write(to_, name);
        asmotion::write(to_, value);
        asmotion_write_end(to_);
    }

private:
    friend class Program;
    explicit Inspection(asmotion_writer* to) : to_(to) {}
    asmotion_writer* to_;
};

/// A component: derive from it, have ports, services, references and properties as members, and override hooks.
///
/// An exception in a hook is a fault of the component; nothing of the cycle is sent.
class Component {
public:
    Component() { cycle_.effects_ = &effects_; }
    Component(const Component&) = delete;
    Component& operator=(const Component&) = delete;
    virtual ~Component() = default;

    /// The properties have their values.
    virtual void configure() {}
    virtual void start() {}
    /// Computes a cycle.
    virtual void update(Cycle&) {}
    /// Computes a cycle in the state RunTimeError.
    virtual void recover(Cycle&) {}
    /// Computes the last cycle.
    virtual void stop(Cycle&) {}
    virtual void cleanup() {}
    virtual void exception() {}
    /// Describes the component for `component info` and `top`: `show("opening", opening)`.
    virtual void inspect(Inspection&) {}
    /// Names what `update` changes, `state(opening)(target)`, so that a run can be frozen and continued. Both are refused
    /// without it.
    virtual void state(State& state);

protected:
    /// The cycle that is being computed.
    Cycle& cycle() { return cycle_; }
    /// Whether the clock is virtual, so that nothing outside may be used.
    bool is_virtual() const { return is_virtual_; }
    /// Requests a cycle, from any thread. In virtual time it has no effect.
    void wake() {
        if (connection_ != nullptr) asmotion_wake(connection_);
    }

private:
    friend class Program;
    friend class State;
    template <class> friend class In;
    template <class> friend class Out;
    template <class> friend class Property;
    template <class> friend class Service;
    template <class> friend class Reference;
    template <class> friend class Reply;
    template <class> friend class Call;

    std::vector<detail::InputBase*> inputs_;
    std::vector<detail::OutputBase*> outputs_;
    std::vector<detail::PropertyBase*> properties_;
    std::vector<detail::ServiceBase*> services_;
    std::vector<detail::ReferenceBase*> references_;
    std::map<std::int64_t, std::shared_ptr<detail::CallBase>> calls_;
    std::int64_t last_call_ = 0;
    /// Requests that wait for a reply.
    std::set<std::int64_t> asked_;
    detail::Effects effects_;
    Cycle cycle_;
    bool is_virtual_ = true;
    asmotion_connection* connection_ = nullptr;
};

/// The samples of an input are commands.
struct Command {};
constexpr Command command{};

/// An input. Samples of one for commands, `{this, "target", "wanted angle", asmotion::command}`, are discarded if they arrive while
/// the component does not run.
template <class T>
class In : detail::InputBase {
public:
    In(Component* owner, std::string name, std::string doc = "") {
        this->name = std::move(name);
        this->doc = std::move(doc);
        owner->inputs_.push_back(this);
    }
    In(Component* owner, std::string name, std::string doc, Command) : In(owner, std::move(name), std::move(doc)) {
        is_command = true;
    }
    In(const In&) = delete;
    In& operator=(const In&) = delete;

    /// The newest sample; `nullptr` if there has been none.
    const T* read() const { return newest_ ? &*newest_ : nullptr; }
    /// The samples that have arrived since the last cycle, in their order.
    const std::vector<T>& all() const { return all_; }
    bool is_new() const { return !all_.empty(); }
    /// Whether the newest sample is older than the connection allows.
    bool is_stale() const { return InputBase::is_stale; }
    /// Number of messages lost since the start.
    std::int64_t lost() const { return InputBase::lost; }
    /// Time of the newest sample.
    std::optional<std::chrono::nanoseconds> written_at() const { return written_at_; }

private:
    void schema(asmotion_writer* to) const override { write_schema<T>(to); }
    void arrive(asmotion_value input) override {
        all_.clear();
        detail::each(asmotion_get(input, "samples"),
                     [&](asmotion_value, asmotion_value sample) { all_.push_back(asmotion::read<T>(sample)); });
        if (all_.empty()) return;
        newest_ = all_.back();
        std::int64_t at = 0;
        written_at_ = std::nullopt;
        if (asmotion_read_int(asmotion_get(input, "written_at"), &at)) written_at_ = std::chrono::nanoseconds(at);
    }
    void freeze(asmotion_writer* to) const override {
        asmotion_write_list(to);
        asmotion::write(to, newest_);
        if (written_at_) asmotion_write_int(to, written_at_->count());
        else asmotion_write_null(to);
        asmotion_write_bool(to, InputBase::is_stale);
        asmotion_write_int(to, InputBase::lost);
        asmotion_write_end(to);
    }
    void thaw(asmotion_value state) override {
        std::vector<asmotion_value> parts;
        detail::each(state, [&](asmotion_value, asmotion_value part) { parts.push_back(part); });
        if (parts.size() != 4) detail::misfit("the state of an input");
        all_.clear();
        newest_ = asmotion::read<std::optional<T>>(parts[0]);
        std::int64_t at = 0;
        written_at_ = std::nullopt;
        if (asmotion_read_int(parts[1], &at)) written_at_ = std::chrono::nanoseconds(at);
        InputBase::is_stale = asmotion::read<bool>(parts[2]);
        InputBase::lost = detail::integer(parts[3]);
    }
    std::optional<T> newest_;
    std::vector<T> all_;
    std::optional<std::chrono::nanoseconds> written_at_;
};

/// An output. The safe sample, if there is one, is written by the engine after the last cycle.
template <class T>
class Out : detail::OutputBase {
public:
    Out(Component* owner, std::string name, std::string doc = "", std::optional<T> safe = std::nullopt)
        : owner_(owner), safe_(std::move(safe)) {
        this->name = std::move(name);
        this->doc = std::move(doc);
        owner->outputs_.push_back(this);
    }
    Out(const Out&) = delete;
    Out& operator=(const Out&) = delete;

    /// Writes a sample, which is sent when the cycle succeeds.
    void write(const T& sample) {
        owner_->effects_.add(owner_->effects_.outputs, [&](asmotion_writer* to) {
            asmotion_write_list(to);
            detail::write(to, name);
            asmotion::write(to, sample);
            asmotion_write_end(to);
        });
    }

private:
    void schema(asmotion_writer* to) const override { write_schema<T>(to); }
    bool write_safe(asmotion_writer* to) const override {
        if (!safe_) return false;
        asmotion_write_text(to, "safe");
        asmotion::write(to, *safe_);
        return true;
    }
    Component* owner_;
    std::optional<T> safe_;
};

/// The unit of a property.
struct unit {
    explicit unit(std::string text) : text(std::move(text)) {}
    std::string text;
};

/// The least and greatest value of a property.
template <class T>
struct range {
    range(T least, T greatest) : least(least), greatest(greatest) {}
    T least, greatest;
};

/// The possible values of a property.
template <class T>
struct choices {
    choices(std::initializer_list<T> values) : values(values) {}
    std::vector<T> values;
};
choices(std::initializer_list<const char*>)->choices<const char*>;

/// A property: a value that the composite gives, `{this, "speed", 0.1, "of the fingers", unit("m/s"), range(0.01, 0.5)}`.
template <class T>
class Property : detail::PropertyBase {
public:
    template <class... Options>
    Property(Component* owner, std::string name, T initial, std::string doc = "", const Options&... options)
        : initial_(std::move(initial)), value_(initial_) {
        this->name = std::move(name);
        this->doc = std::move(doc);
        (apply(options), ...);
        owner->properties_.push_back(this);
    }
    Property(const Property&) = delete;
    Property& operator=(const Property&) = delete;

    const T& value() const { return value_; }
    operator const T&() const { return value_; }

private:
    void apply(const unit& option) { unit_text = option.text; }
    template <class U>
    void apply(const range<U>& option) {
        range_ = {static_cast<T>(option.least), static_cast<T>(option.greatest)};
    }
    template <class U>
    void apply(const choices<U>& option) {
        for (const U& value : option.values) choices_.push_back(T(value));
    }
    void schema(asmotion_writer* to) const override { write_schema<T>(to); }
    void values(asmotion_writer* to) const override {
        asmotion_write_text(to, "default");
        asmotion::write(to, initial_);
        if (range_) {
            asmotion_write_text(to, "range");
            asmotion_write_list(to);
            asmotion::write(to, range_->first);
            asmotion::write(to, range_->second);
            asmotion_write_end(to);
        }
        if (!choices_.empty()) {
            asmotion_write_text(to, "choices");
            asmotion_write_list(to);
            for (const T& value : choices_) asmotion::write(to, value);
            asmotion_write_end(to);
        }
    }
    void set(asmotion_value value) override { value_ = asmotion::read<T>(value); }
    T initial_, value_;
    std::optional<std::pair<T, T>> range_;
    std::vector<T> choices_;
};

/// The way to reply to a request, in the cycle in which it arrived or in a later one.
template <class Response>
class Reply {
public:
    Reply() = default;
    /// Ends the request. Has no effect if the caller no longer waits.
    void operator()(const Response& response) const {
        if (!is_awaited()) return;
        owner_->effects_.add(owner_->effects_.replies, [&](asmotion_writer* to) {
            asmotion_write_map(to);
            asmotion_write_text(to, "id");
            asmotion_write_int(to, asked_.id);
            asmotion_write_text(to, "result");
            asmotion::write(to, response);
            asmotion_write_end(to);
        });
        owner_->asked_.erase(asked_.id);
    }
    /// Ends the request with a fault.
    void refuse(const std::string& code, const std::string& text) const {
        if (!is_awaited()) return;
        owner_->effects_.add(owner_->effects_.replies, [&](asmotion_writer* to) {
            asmotion_write_map(to);
            asmotion_write_text(to, "id");
            asmotion_write_int(to, asked_.id);
            asmotion_write_text(to, "fault");
            asmotion_write_map(to);
            detail::entry(to, "code", code);
            detail::entry(to, "text", text);
            asmotion_write_end(to);
            asmotion_write_end(to);
        });
        owner_->asked_.erase(asked_.id);
    }
    /// Whether the caller still waits.
    bool is_awaited() const { return owner_ != nullptr && owner_->asked_.count(asked_.id) > 0; }
    const std::string& caller() const { return asked_.caller; }
    /// Time at which the caller gives up; none for a one-way request.
    std::optional<std::chrono::nanoseconds> deadline() const {
        if (!asked_.deadline) return std::nullopt;
        return std::chrono::nanoseconds(*asked_.deadline);
    }

private:
    template <class> friend class Service;
    friend class State;
    Reply(Component* owner, detail::Asked asked) : owner_(owner), asked_(std::move(asked)) {}
    Component* owner_ = nullptr;
    detail::Asked asked_;
};

/// An operation is also served while the component is stopped.
struct WhileStopped {};
constexpr WhileStopped while_stopped{};

/// A service. The constructor of the component says how it serves: `grip.on<Grip::close>([this](const Close& request) …)`.
template <class Interface>
class Service : detail::ServiceBase {
public:
    Service(Component* owner, std::string name, std::string doc = "") : owner_(owner) {
        this->name = std::move(name);
        this->doc = std::move(doc);
        interface = Interface::interface_name;
        owner->services_.push_back(this);
    }
    Service(const Service&) = delete;
    Service& operator=(const Service&) = delete;

    /// Serves an operation by a function of the request that returns the response, or by one that also takes a
    /// `Reply<Response>` and may keep it. A `Fault` is the reply to the caller.
    template <class Operation, class Handler>
    Service& on(Handler handler) {
        using Request = typename Operation::request;
        using Response = typename Operation::response;
        detail::Served served;
        served.name = Operation::operation_name;
        served.request = &write_schema<Request>;
        served.response = &write_schema<Response>;
        served.handle = [this, handler](asmotion_value argument, const detail::Asked& asked) {
            Reply<Response> reply(owner_, asked);
            const Request request = asmotion::read<Request>(argument);
            try {
                if constexpr (std::is_invocable_v<Handler, const Request&, Reply<Response>>) handler(request, reply);
                else reply(handler(request));
            } catch (const Misfit&) {
                throw;
            } catch (const Fault& fault) {
                reply.refuse(fault.code, fault.what());
            }
        };
        operations.push_back(std::move(served));
        return *this;
    }
    template <class Operation, class Handler>
    Service& on(Handler handler, WhileStopped) {
        on<Operation>(std::move(handler));
        operations.back().while_stopped = true;
        return *this;
    }

private:
    Component* owner_;
};

/// A call that has begun. Copies are the same call.
template <class Response>
class Call {
public:
    Call() = default;
    /// Whether the call has ended.
    bool is_done() const { return state_ && state_->is_done; }
    explicit operator bool() const { return state_ != nullptr; }
    /// The result. Throws `CallError` if the call has failed.
    const Response& result() const {
        if (!is_done()) throw std::logic_error("the call has not ended");
        if (state_->error) throw *state_->error;
        return *state_->result;
    }
    /// Ends the call without its result; it ends with the error `cancelled`.
    void cancel() const {
        if (!state_ || state_->is_done) return;
        owner_->effects_.add(owner_->effects_.cancel, [&](asmotion_writer* to) { asmotion_write_int(to, state_->id); });
    }

private:
    template <class> friend class Reference;
    friend class State;
    Component* owner_ = nullptr;
    std::shared_ptr<detail::CallState<Response>> state_;
};

/// The component also works without a service.
struct Optional {};
constexpr Optional optional{};

/// A reference to a service. Deadlines are those of the wire.
template <class Interface>
class Reference : detail::ReferenceBase {
public:
    Reference(Component* owner, std::string name, std::string doc = "") : owner_(owner) {
        this->name = std::move(name);
        this->doc = std::move(doc);
        interface = Interface::interface_name;
        operations = [](asmotion_writer* to) {
            Interface::operations([&](auto operation) { detail::write_operation<decltype(operation)>(to, false); });
        };
        owner->references_.push_back(this);
    }
    Reference(Component* owner, std::string name, std::string doc, Optional)
        : Reference(owner, std::move(name), std::move(doc)) {
        is_optional = true;
    }
    Reference(const Reference&) = delete;
    Reference& operator=(const Reference&) = delete;

    /// Calls an operation. The call ends in a later cycle.
    template <class Operation>
    Call<typename Operation::response> call(const typename Operation::request& request) {
        Call<typename Operation::response> call;
        call.owner_ = owner_;
        call.state_ = std::make_shared<detail::CallState<typename Operation::response>>();
        call.state_->id = begin<Operation>(request, false);
        owner_->calls_[call.state_->id] = call.state_;
        return call;
    }
    /// Sends a request without a reply.
    template <class Operation>
    void notify(const typename Operation::request& request) {
        begin<Operation>(request, true);
    }

private:
    template <class Operation>
    std::int64_t begin(const typename Operation::request& request, bool is_one_way) {
        const std::int64_t id = ++owner_->last_call_;
        owner_->effects_.add(owner_->effects_.calls, [&](asmotion_writer* to) {
            asmotion_write_map(to);
            asmotion_write_text(to, "call");
            asmotion_write_int(to, id);
            detail::entry(to, "reference", name);
            asmotion_write_entry(to, "operation", Operation::operation_name);
            asmotion_write_text(to, "argument");
            asmotion::write(to, request);
            if (is_one_way) {
                asmotion_write_text(to, "one_way");
                asmotion_write_bool(to, true);
            }
            asmotion_write_end(to);
        });
        return id;
    }
    Component* owner_;
};

// ---- Frozen state ---------------------------------------------------------------------------------------------------

/// The state of a component as it is frozen or thawed: a list of what `Component::state` names.
class State {
public:
    /// Writes or reads data, calls, replies, containers of them, and types with a function `state(State&)`.
    template <class T>
    State& operator()(T& value) {
        if (is_supported_) exchange(value);
        return *this;
    }

private:
    friend class Component;
    friend class Program;
    State(Component* owner, asmotion_writer* to) : owner_(owner), to_(to) {}
    State(Component* owner, asmotion_value from) : owner_(owner), from_(asmotion_iterate(from)) {}

    asmotion_value next() {
        asmotion_value part = {nullptr, nullptr};
        if (!asmotion_next(&from_, nullptr, &part)) detail::misfit("a longer state");
        return part;
    }
    template <class T>
    void exchange(T& value) {
        if constexpr (detail::HasForm<T>::value) {
            if (to_ != nullptr) asmotion::write(to_, value);
            else value = asmotion::read<T>(next());
        } else {
            exchange_parts(value);
        }
    }
    template <class T>
    void exchange_parts(T& value) {
        value.state(*this);
    }
    template <class A, class B>
    void exchange_parts(std::pair<A, B>& pair) {
        exchange(pair.first);
        exchange(pair.second);
    }
    template <class T>
    void exchange_parts(std::optional<T>& value) {
        bool has_value = value.has_value();
        exchange(has_value);
        if (has_value && !value) value.emplace();
        if (!has_value) value.reset();
        if (value) exchange(*value);
    }
    template <class T>
    void exchange_parts(std::vector<T>& list) {
        exchange_list(list);
    }
    template <class T>
    void exchange_parts(std::deque<T>& list) {
        exchange_list(list);
    }
    template <class List>
    void exchange_list(List& list) {
        std::uint64_t count = list.size();
        exchange(count);
        if (to_ == nullptr) list.clear();
        for (std::uint64_t index = 0; index < count; index++) {
            if (to_ == nullptr) list.emplace_back();
            exchange(list[static_cast<std::size_t>(index)]);
        }
    }
    template <class K, class V>
    void exchange_parts(std::map<K, V>& map) {
        std::vector<std::pair<K, V>> list(map.begin(), map.end());
        exchange_list(list);
        if (to_ == nullptr) map = std::map<K, V>(list.begin(), list.end());
    }
    template <class Response>
    void exchange_parts(Reply<Response>& reply) {
        exchange(reply.asked_.id);
        exchange(reply.asked_.caller);
        exchange(reply.asked_.deadline);
        if (to_ == nullptr) reply.owner_ = owner_;
    }
    template <class Response>
    void exchange_parts(Call<Response>& call) {
        bool has_state = call.state_ != nullptr;
        exchange(has_state);
        if (to_ == nullptr) {
            call.owner_ = owner_;
            call.state_ = has_state ? std::make_shared<detail::CallState<Response>>() : nullptr;
        }
        if (!has_state) return;
        detail::CallState<Response>& state = *call.state_;
        bool has_error = state.error.has_value();
        exchange(state.id);
        exchange(state.is_done);
        exchange(state.result);
        exchange(has_error);
        if (has_error) {
            CallError error = state.error.value_or(CallError("", "", ""));
            exchange(error.kind);
            exchange(error.code);
            exchange(error.text);
            state.error = CallError(error.kind, error.code, error.text);
        }
        // copies of a handle are one call
        auto known = owner_->calls_.find(state.id);
        if (to_ == nullptr && known != owner_->calls_.end()) {
            call.state_ = std::static_pointer_cast<detail::CallState<Response>>(known->second);
        } else if (to_ == nullptr && !state.is_done) {
            owner_->calls_[state.id] = call.state_;
        }
    }

    Component* owner_;
    asmotion_writer* to_ = nullptr;
    asmotion_iterator from_ = {{nullptr, nullptr}, 0, false};
    bool is_supported_ = true;
};

inline void Component::state(State& state) { state.is_supported_ = false; }

// ---- The program ----------------------------------------------------------------------------------------------------

/// Answers the requests of the engine for one component.
class Program {
public:
    using Make = std::function<std::unique_ptr<Component>()>;

    Program(Make make, std::string implementation)
        : make_(std::move(make)), implementation_(std::move(implementation)), component_(make_()) {}

    /// Runs until the engine ends the program. Returns its exit status.
    int run() {
        if (std::getenv("ASMOTION_SOCKET") == nullptr || !asmotion_connect(&connection_)) {
            return asmotion_run(nullptr, nullptr);
        }
        asmotion_value request = {nullptr, nullptr};
        asmotion_received received;
        while ((received = asmotion_receive(&connection_, &request)) == ASMOTION_REQUEST) {
            if (asmotion_is_text(asmotion_get(request, "type"), "exit")) break;
            answer(request);
            std::cout.flush();
            std::cerr.flush();
            if (!asmotion_send(&connection_)) break;
        }
        if (received == ASMOTION_GARBAGE) std::cerr << "the engine sent something that is no message" << std::endl;
        component_.reset();
        asmotion_close(&connection_);
        return received == ASMOTION_GARBAGE ? 1 : 0;
    }

private:
    void answer(asmotion_value request) {
        try {
            asmotion_answer(&connection_, request, &Program::handle, this);
        } catch (const Fault& fault) {
            asmotion_refuse(&connection_, fault.code.c_str(), fault.what());
        } catch (const std::exception& error) {
            asmotion_refuse(&connection_, "EXCEPTION", error.what());
        }
    }

    /// C++ exceptions pass through `asmotion_answer`, which holds nothing.
    static const char* handle(void* program, const char* type, asmotion_value request, asmotion_writer* reply) {
        return static_cast<Program*>(program)->handle(std::string(type), request, reply);
    }

    const char* handle(const std::string& type, asmotion_value request, asmotion_writer* reply) {
        if (type == "hello") return hello(request, reply);
        if (type == "configure") return configure(request);
        if (type == "start") component_->start();
        if (type == "cleanup") component_->cleanup();
        if (type == "exception") component_->exception();
        if (type == "inspect") return inspect(reply);
        if (type == "freeze") return freeze(reply);
        if (type == "thaw") return thaw(asmotion_get(request, "state"));
        if (type == "cycle" || type == "recover" || type == "serve" || type == "stop") return cycle(type, request, reply);
        return nullptr;
    }

    const char* hello(asmotion_value request, asmotion_writer* reply) {
        component_->is_virtual_ = !asmotion_is_text(asmotion_get(request, "clock"), "wall");
        if (!implementation_.empty()) detail::entry(reply, "implementation", implementation_);
        declare(reply, "inputs", component_->inputs_, [&](const detail::InputBase& it) {
            asmotion_write_text(reply, "schema");
            it.schema(reply);
            if (it.is_command) {
                asmotion_write_text(reply, "command");
                asmotion_write_bool(reply, true);
            }
        });
        declare(reply, "outputs", component_->outputs_, [&](const detail::OutputBase& it) {
            asmotion_write_text(reply, "schema");
            it.schema(reply);
            it.write_safe(reply);
        });
        declare(reply, "services", component_->services_, [&](const detail::ServiceBase& it) { service(reply, it); });
        declare(reply, "references", component_->references_, [&](const detail::ReferenceBase& it) {
            detail::entry(reply, "interface", it.interface);
            if (it.is_optional) {
                asmotion_write_text(reply, "optional");
                asmotion_write_bool(reply, true);
            }
            asmotion_write_text(reply, "operations");
            asmotion_write_list(reply);
            it.operations(reply);
            asmotion_write_end(reply);
        });
        declare(reply, "properties", component_->properties_, [&](const detail::PropertyBase& it) {
            if (!it.unit_text.empty()) detail::entry(reply, "unit", it.unit_text);
            asmotion_write_text(reply, "schema");
            it.schema(reply);
            it.values(reply);
        });
        return nullptr;
    }

    template <class Part, class Write>
    static void declare(asmotion_writer* reply, const char* key, const std::vector<Part*>& parts, Write&& write) {
        asmotion_write_text(reply, key);
        asmotion_write_list(reply);
        for (const Part* part : parts) {
            asmotion_write_map(reply);
            detail::entry(reply, "name", part->name);
            detail::entry(reply, "doc", part->doc);
            write(*part);
            asmotion_write_end(reply);
        }
        asmotion_write_end(reply);
    }

    static void service(asmotion_writer* reply, const detail::ServiceBase& service) {
        detail::entry(reply, "interface", service.interface);
        asmotion_write_text(reply, "operations");
        asmotion_write_list(reply);
        for (const detail::Served& served : service.operations) {
            asmotion_write_map(reply);
            detail::entry(reply, "name", served.name);
            asmotion_write_text(reply, "request");
            served.request(reply);
            asmotion_write_text(reply, "response");
            served.response(reply);
            if (served.while_stopped) {
                asmotion_write_text(reply, "while_stopped");
                asmotion_write_bool(reply, true);
            }
            asmotion_write_end(reply);
        }
        asmotion_write_end(reply);
    }

    const char* configure(asmotion_value request) {
        if (is_configured_) {
            const bool is_virtual = component_->is_virtual_;
            component_.reset();
            component_ = make_();
            component_->is_virtual_ = is_virtual;
        }
        is_configured_ = true;
        component_->connection_ = &connection_;
        component_->effects_.shared = connection_.reply_memory;
        component_->effects_.shared_size = connection_.reply_memory == nullptr ? 0 : connection_.memory_size;
        set_properties(request);
        component_->configure();
        return nullptr;
    }

    void set_properties(asmotion_value request) {
        asmotion_value values = asmotion_get(request, "properties");
        if (asmotion_is_absent(values)) return;
        for (detail::PropertyBase* property : component_->properties_) {
            asmotion_value value = asmotion_get(values, property->name.c_str());
            if (!asmotion_is_absent(value)) detail::at("property", property->name, [&] { property->set(value); });
        }
    }

    const char* cycle(const std::string& type, asmotion_value request, asmotion_writer* reply) {
        Component& component = *component_;
        Cycle& cycle = component.cycle_;
        component.effects_.clear();
        cycle.now_ = detail::integer(asmotion_get(request, "now"));
        cycle.number_ = detail::integer(asmotion_get(request, "number"));
        cycle.is_running_ = type != "serve";
        if (type == "cycle" || type == "recover") freeze_inputs(request);
        set_properties(request);
        end_calls(asmotion_get(request, "replies"));
        detail::each(asmotion_get(request, "cancelled"), [&](asmotion_value, asmotion_value id) {
            component.asked_.erase(detail::integer(id));
        });
        detail::each(asmotion_get(request, "requests"), [&](asmotion_value, asmotion_value asked) { serve(asked); });
        if (type == "cycle") component.update(cycle);
        if (type == "recover") component.recover(cycle);
        if (type == "stop") component.stop(cycle);
        write_effects(reply);
        return nullptr;
    }

    void freeze_inputs(asmotion_value request) {
        asmotion_value arrived = asmotion_get(request, "inputs"), lost = asmotion_get(request, "lost");
        std::set<std::string> stale;
        detail::each(asmotion_get(request, "stale"),
                     [&](asmotion_value, asmotion_value name) { stale.insert(detail::text(name)); });
        for (detail::InputBase* input : component_->inputs_) {
            detail::at("input", input->name, [&] { input->arrive(asmotion_get(arrived, input->name.c_str())); });
            input->is_stale = stale.count(input->name) > 0;
            asmotion_value count = asmotion_get(lost, input->name.c_str());
            if (!asmotion_is_absent(count)) input->lost = detail::integer(count);
        }
    }

    void end_calls(asmotion_value replies) {
        detail::each(replies, [&](asmotion_value, asmotion_value ended) {
            auto found = component_->calls_.find(detail::integer(asmotion_get(ended, "call")));
            if (found == component_->calls_.end()) return;
            std::shared_ptr<detail::CallBase> call = found->second;
            component_->calls_.erase(found);
            asmotion_value error = asmotion_get(ended, "error");
            auto part = [&](const char* key) {
                asmotion_value value = asmotion_get(error, key);
                return asmotion_is_absent(value) ? std::string() : detail::text(value);
            };
            if (asmotion_is_absent(error)) call->finish(asmotion_get(ended, "result"));
            else call->error = CallError(part("kind"), part("code"), part("text"));
            call->is_done = true;
        });
    }

    void serve(asmotion_value request) {
        detail::Asked asked;
        std::int64_t deadline = 0;
        asked.id = detail::integer(asmotion_get(request, "id"));
        asked.caller = detail::text(asmotion_get(request, "caller"));
        if (asmotion_read_int(asmotion_get(request, "deadline"), &deadline)) {
            asked.deadline = deadline;
            component_->asked_.insert(asked.id);
        }
        const std::string service = detail::text(asmotion_get(request, "service"));
        const std::string operation = detail::text(asmotion_get(request, "operation"));
        for (detail::ServiceBase* it : component_->services_) {
            for (const detail::Served& served : it->operations) {
                if (it->name == service && served.name == operation) {
                    served.handle(asmotion_get(request, "argument"), asked);
                    return;
                }
            }
        }
        throw Misfit("a request of `" + service + "." + operation + "`, which is not declared");
    }

    void write_effects(asmotion_writer* reply) {
        detail::Effects& effects = component_->effects_;
        list(reply, "outputs", effects.outputs);
        list(reply, "calls", effects.calls);
        list(reply, "cancel", effects.cancel);
        list(reply, "replies", effects.replies);
        list(reply, "reports", effects.reports);
        if (effects.again) {
            asmotion_write_text(reply, "again");
            asmotion_write_bool(reply, true);
        }
        if (effects.at) {
            asmotion_write_text(reply, "at");
            asmotion_write_int(reply, *effects.at);
        }
        if (effects.period) {
            asmotion_write_text(reply, "period");
            asmotion_write_int(reply, *effects.period);
        }
        if (effects.duration) {
            asmotion_write_text(reply, "duration");
            asmotion_write_int(reply, *effects.duration);
        }
        if (effects.error) {
            asmotion_write_text(reply, "error");
            asmotion_write_map(reply);
            detail::entry(reply, "code", effects.error->code);
            detail::entry(reply, "text", effects.error->what());
            asmotion_write_end(reply);
        }
    }

    static void list(asmotion_writer* reply, const char* key, const detail::Buffer& elements) {
        if (elements.size == 0) return;
        asmotion_write_text(reply, key);
        asmotion_write_list(reply);
        asmotion__write(reply, elements.bytes, elements.size);
        asmotion_write_end(reply);
    }

    const char* inspect(asmotion_writer* reply) {
        asmotion_write_text(reply, "fields");
        asmotion_write_list(reply);
        Inspection inspection(reply);
        component_->inspect(inspection);
        asmotion_write_end(reply);
        return nullptr;
    }

    const char* freeze(asmotion_writer* reply) {
        detail::Buffer bytes;
        State state(component_.get(), &bytes);
        asmotion_write_list(&bytes);
        state(component_->last_call_);
        std::vector<std::int64_t> asked(component_->asked_.begin(), component_->asked_.end());
        state(asked);
        for (const detail::InputBase* input : component_->inputs_) input->freeze(&bytes);
        component_->state(state);
        asmotion_write_end(&bytes);
        if (!state.is_supported_) {
            asmotion_write_entry(reply, "text", "the component has no function `state`");
            return "unsupported";
        }
        asmotion_write_text(reply, "state");
        asmotion_write_bytes(reply, bytes.bytes, bytes.size);
        return "frozen";
    }

    const char* thaw(asmotion_value frozen) {
        asmotion_bytes bytes = {nullptr, 0};
        if (!asmotion_read_bytes(frozen, &bytes)) detail::misfit("a state");
        const asmotion_document document = {bytes.data, bytes.data + bytes.size, nullptr, 0};
        if (!asmotion_check(&document)) detail::misfit("a state of this program");
        State state(component_.get(), asmotion_root(&document));
        std::vector<std::int64_t> asked;
        component_->calls_.clear();
        state(component_->last_call_)(asked);
        component_->asked_ = std::set<std::int64_t>(asked.begin(), asked.end());
        for (detail::InputBase* input : component_->inputs_) input->thaw(state.next());
        component_->state(state);
        return state.is_supported_ ? "ok" : "unsupported";
    }

    Make make_;
    std::string implementation_;
    asmotion_connection connection_{};
    std::unique_ptr<Component> component_;
    bool is_configured_ = false;
};

/// Runs a component as the program that asmotion has started. Returns the exit status of the program.
template <class C>
int run(const std::string& implementation = "") {
    Program program([] { return std::make_unique<C>(); }, implementation);
    return program.run();
}

}  // namespace asmotion

#endif
