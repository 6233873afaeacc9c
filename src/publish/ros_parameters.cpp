#include "publish/ros_parameters.h"

#include <algorithm>
#include <exception>
#include <string_view>

#include <fmt/ranges.h>

#include "publish/cdr.h"

namespace slipstream {
namespace {

/// rcl_interfaces/msg/ParameterType
enum class Kind : std::uint8_t { none = 0, boolean = 1, integer = 2, real = 3, text = 4 };

using Settings = std::vector<RunSetting>;
struct Wish {
  std::string name, value;
};

/// Kind::none for an unknown setting.
Kind kind_of(const RunSetting& setting) {
  if (setting.name.empty()) return Kind::none;
  if (setting.choices.empty()) return Kind::real;
  return setting.choices == std::vector<std::string>{"off", "on"} ? Kind::boolean : Kind::text;
}

/// Empty while the run cannot read them, for example while its camera shuts down: a service of
/// ROS 2 has no other answer, and without one its client would wait.
Settings known_settings(const PublishedRun& run) try {
  return run.settings();
} catch (const std::exception&) {
  return {};
}

RunSetting find(const Settings& settings, std::string_view name) {
  const auto found = std::ranges::find(settings, name, &RunSetting::name);
  return found == settings.end() ? RunSetting() : *found;
}

/// A ParameterValue.
void add_value(const RunSetting& setting, Cdr& cdr) {
  const Kind kind = kind_of(setting);
  // A field for each type, all present: only the one named by `kind` counts.
  cdr.add(kind).add(static_cast<std::uint8_t>(kind == Kind::boolean && setting.value == "on"));
  cdr.add(std::int64_t{0}).add(number_in<double>(setting.value).value_or(0));
  cdr.add_text(kind == Kind::text ? setting.value : "");
  for (int list = 0; list < 5; ++list) cdr.add_count(0);
}

std::string read_value(CdrReader& cdr) {
  // All fields must be read, used or not.
  const auto kind = cdr.get<Kind>();
  const bool on = cdr.get<std::uint8_t>() != 0;
  const auto integer = cdr.get<std::int64_t>();
  const auto real = cdr.get<double>();
  std::string text(cdr.text());

  // Lists of bytes, booleans, integers and reals, then of texts.
  for (const std::size_t size : {1, 1, 8, 8}) cdr.list(size);
  for (std::uint32_t texts = cdr.count(); texts > 0; --texts) cdr.text();

  return kind == Kind::boolean   ? (on ? "on" : "off")
         : kind == Kind::integer ? fmt::format("{}", integer)
         : kind == Kind::real    ? fmt::format("{}", real)
                                 : std::move(text);  // empty for other kinds
}

template <class Read>
auto read_list(CdrReader& request, Read read) {
  std::vector<decltype(read(request))> list;
  for (std::uint32_t left = request.count(); left > 0; --left) list.push_back(read(request));
  return list;
}

std::string read_name(CdrReader& request) {
  return std::string(request.text());
}

Wish read_wish(CdrReader& request) {
  return {read_name(request), read_value(request)};  // in this order
}

/// Sets all or none, as far as a camera can be set back.
void change_all(const PublishedRun& run, const std::vector<Wish>& wishes) {
  const Settings before = run.settings();
  // Check all before the first change; if a camera still refuses one, undo the others.
  for (const auto& [name, value] : wishes) require_settable(before, name, value);

  for (std::size_t done = 0; done < wishes.size(); ++done) {
    try {
      run.change(wishes[done].name, wishes[done].value);
    } catch (...) {
      while (done-- > 0) run.change(wishes[done].name, find(before, wishes[done].name).value);
      throw;
    }
  }
}

void add_description(const std::string& name, const RunSetting& setting, Cdr& cdr) {
  const bool is_number = kind_of(setting) == Kind::real;
  cdr.add_text(name).add(kind_of(setting));
  cdr.add_text(setting.help + (setting.unit.empty() ? "" : ", " + setting.unit));
  cdr.add_text(fmt::format("{}", fmt::join(setting.choices, "; ")));

  cdr.add(std::uint8_t{0}).add(std::uint8_t{0});  // writable, of fixed type

  // Range: least, most, and step 0 for any value between.
  cdr.add_count(is_number ? 1 : 0);
  if (is_number) cdr.add(setting.least).add(setting.most).add(0.0);
  cdr.add_count(0);  // integer ranges
}

}  // namespace

std::vector<RosService> parameter_services(const std::string& node, const PublishedRun& run) {
  const auto service = [&](const char* name, const char* type, auto answer) {
    return RosService{node + "/" + name, std::string("rcl_interfaces/srv/") + type,
                      std::move(answer)};
  };

  /// A reply per requested name.
  const auto of_each = [&run](auto add) {
    return [&run, add](CdrReader& request, Cdr& answer) {
      const Settings settings = known_settings(run);
      const std::vector<std::string> names = read_list(request, read_name);
      answer.add_count(names.size());
      for (const std::string& name : names) add(name, find(settings, name), answer);
    };
  };

  return {
      service("describe_parameters", "DescribeParameters", of_each(add_description)),
      service("get_parameters", "GetParameters",
              of_each([](const std::string&, const RunSetting& setting, Cdr& answer) {
                add_value(setting, answer);
              })),
      service("get_parameter_types", "GetParameterTypes",
              of_each([](const std::string&, const RunSetting& setting, Cdr& answer) {
                answer.add(kind_of(setting));
              })),
      service("list_parameters", "ListParameters",
              [&run](CdrReader& request, Cdr& answer) {
                const std::vector<std::string> wanted = read_list(request, read_name);
                Settings listed = known_settings(run);
                std::erase_if(listed, [&](const RunSetting& setting) {
                  return !wanted.empty() && std::ranges::count(wanted, setting.name) == 0;
                });
                answer.add_count(listed.size());
                for (const RunSetting& setting : listed) answer.add_text(setting.name);
                answer.add_count(0);  // names are not nested
              }),
      service("set_parameters", "SetParameters",
              [&run](CdrReader& request, Cdr& answer) {
                const std::vector<Wish> wishes = read_list(request, read_wish);
                answer.add_count(wishes.size());
                for (const auto& [name, value] : wishes) {
                  add_outcome(answer, [&, &name = name, &value = value] {
                    run.change(name, value);
                    return "";
                  });
                }
              }),
      service("set_parameters_atomically", "SetParametersAtomically",
              [&run](CdrReader& request, Cdr& answer) {
                const std::vector<Wish> wishes = read_list(request, read_wish);
                add_outcome(answer, [&] {
                  change_all(run, wishes);
                  return "";
                });
              }),
  };
}

bool write_parameter_event(const std::string& node, std::uint64_t time, const Settings& before,
                           const Settings& now, RosMessage& message) {
  Settings come, changed, gone = before;
  for (const RunSetting& setting : now) {
    const RunSetting was = find(before, setting.name);
    if (was.name.empty()) come.push_back(setting);
    if (!was.name.empty() && was.value != setting.value) changed.push_back(setting);
  }

  std::erase_if(gone, [&](const RunSetting& was) { return !find(now, was.name).name.empty(); });
  if (come.empty() && changed.empty() && gone.empty()) return false;

  Cdr cdr(message);
  cdr.add_time(time).add_text("/" + node);

  for (const auto& list : {come, changed, gone}) {
    cdr.add_count(list.size());
    for (const RunSetting& setting : list) add_value(setting, cdr.add_text(setting.name));
  }
  return true;
}

}  // namespace slipstream
