#include "plant/parameters/layout_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <functional>
#include <map>
#include <numbers>

#include "io/input_file.hpp"
#include "io/toml.hpp"
#include "plant/numerics/math.hpp"

namespace plant {
namespace {

[[noreturn]] void refuse(const toml::source_region& at, const std::string& name, const std::string& what) {
  throw LayoutError(fmt::format("{}:{}:{}: {}", name, at.begin.line, at.begin.column, what));
}

// The fields of one table; a field that is never taken is an error.
class Fields {
 public:
  using Take = std::function<void(const toml::node&, const std::string& key)>;

  Fields(const toml::table& table, const std::string& file, std::string what)
      : table_(table), file_(file), what_(std::move(what)) {}

  double number(const toml::node& node, const std::string& key) const {
    const auto value = node.value<double>();
    if (!value || node.is_boolean() || !std::isfinite(*value))
      refuse(node.source(), file_, fmt::format("{} of {} needs a number", key, what_));
    return *value;
  }
  std::vector<double> numbers(const toml::node& node, const std::string& key, std::size_t count) const {
    const toml::array* array = node.as_array();
    if (array == nullptr || (count > 0 && array->size() != count))
      refuse(node.source(), file_,
             fmt::format("{} of {} needs a list of {}numbers", key, what_, count > 0 ? fmt::format("{} ", count) : ""));
    std::vector<double> all;
    for (const toml::node& element : *array) all.push_back(number(element, key));
    return all;
  }

  Fields& on(const std::string& key, Take take) {
    takes_[key] = std::move(take);
    return *this;
  }
  Fields& number_to(const std::string& key, double& to, double unit = 1.0) {
    return on(key, [this, &to, unit](const toml::node& node, const std::string& k) { to = unit * number(node, k); });
  }
  Fields& range_to(const std::string& key, double& low, double& high) {
    return on(key, [this, &low, &high](const toml::node& node, const std::string& k) {
      const auto pair = numbers(node, k, 2);
      low = pair[0], high = pair[1];
    });
  }
  Fields& flag_to(const std::string& key, bool& to) {
    return on(key, [this, &to](const toml::node& node, const std::string& k) {
      if (!node.is_boolean()) refuse(node.source(), file_, fmt::format("{} of {} needs true or false", k, what_));
      to = *node.value<bool>();
    });
  }
  Fields& choice_to(const std::string& key, const std::vector<std::string>& names,
                    const std::function<void(std::size_t)>& set) {
    return on(key, [this, names, set](const toml::node& node, const std::string& k) {
      const auto value = node.value<std::string>();
      for (std::size_t i = 0; i < names.size(); ++i)
        if (value == names[i]) return set(i);
      refuse(node.source(), file_, fmt::format("{} of {} needs one of \"{}\"", k, what_, fmt::join(names, "\", \"")));
    });
  }
  // Ends the table; the fields in `needed` must be there.
  void done(const std::vector<std::string>& needed = {}) {
    for (const auto& [key, node] : table_) {
      const auto take = takes_.find(std::string(key.str()));
      if (take == takes_.end()) {
        std::vector<std::string> known;
        for (const auto& [k, f] : takes_) known.push_back(k);
        refuse(key.source(), file_, fmt::format("{} has no {}; it has {}", what_, key.str(), fmt::join(known, ", ")));
      }
      take->second(node, take->first);
    }
    for (const std::string& key : needed)
      if (!table_.contains(key)) refuse(table_.source(), file_, fmt::format("{} needs {}", what_, key));
  }

 private:
  const toml::table& table_;
  const std::string& file_;
  std::string what_;
  std::map<std::string, Take> takes_;
};

class Reader {
 public:
  Reader(DockConfig& config, const std::string& file) : c_(config), layout_(config.layout), file_(file) {}

  void read(const toml::table& root) {
    const Pose old_spot = layout_.spot, old_warehouse = layout_.warehouse;
    const double spacing = layout_.slot_spacing;
    Fields fields(root, file_, "the layout");
    fields.number_to("deck_m", layout_.deck).number_to("slot_spacing_m", layout_.slot_spacing);
    fields.on("rows_m", [&](const toml::node& n, const std::string& k) {
      layout_.rows = fields.numbers(n, k, 0);
      if (layout_.rows.empty())
        ::plant::refuse(n.source(), file_, "rows_m of the layout is an empty list; the bay needs at least one row");
    });
    table(fields, "home", [this](const toml::table& t) { home(t); });
    table(fields, "ship", [this](const toml::table& t) { box(t, "the ship", layout_.ship); });
    table(fields, "spot", [this](const toml::table& t) { spot(t); });
    table(fields, "warehouse", [this](const toml::table& t) { warehouse_of(t); });
    table(fields, "portal", [this](const toml::table& t) {
      Portal& p = c_.crane.portal;
      Fields(t, file_, "the portal")
          .number_to("along_m", p.along)
          .number_to("landside_m", p.landside)
          .number_to("waterside_m", p.waterside)
          .number_to("leg_m", p.leg)
          .number_to("height_m", p.height)
          .done();
    });
    table(fields, "agv", [this](const toml::table& t) { agv(t); });
    table(fields, "sensors", [this](const toml::table& t) {
      Fields(t, file_, "sensors")
          .number_to("range_rate_hz", c_.sensors.range_rate)
          .number_to("range_dropout", c_.sensors.range_dropout)
          .done();
    });
    const toml::node* containers = nullptr;
    fields.on("containers", [&containers](const toml::node& n, const std::string&) { containers = &n; });
    list(fields, "boxes", layout_.no_go, [this](const toml::table& t) {
      Box b{};
      box(t, "a box", b);
      return b;
    });
    layout_.movers.clear();
    list(fields, "posts", layout_.movers, [this](const toml::table& t) { return post(t); }, false);
    list(fields, "movers", layout_.movers, [this](const toml::table& t) { return mover(t); }, false);
    const toml::table* lane_table = nullptr;
    table(fields, "lanes", [&lane_table](const toml::table& t) { lane_table = &t; });
    fields.done();
    if (root.contains("deck_m") && !root.contains("ship")) layout_.ship.z_max = layout_.deck;
    // Here deck, spot and warehouse are known.
    if (containers != nullptr)
      take_list(
          *containers, "containers", layout_.containers, [this](const toml::table& t) { return container(t); }, true);
    std::vector<LaneSegment> lanes[2];
    if (lane_table != nullptr) lanes_of(*lane_table, lanes);
    const bool moved = old_spot.heading != layout_.spot.heading || old_spot.x != layout_.spot.x ||
                       old_spot.y != layout_.spot.y || old_warehouse.x != layout_.warehouse.x ||
                       old_warehouse.y != layout_.warehouse.y || old_warehouse.heading != layout_.warehouse.heading ||
                       spacing != layout_.slot_spacing;
    if (!lanes[0].empty() || !lanes[1].empty())
      layout_.legs = {lanes[0], lanes[1], lanes[1]};
    else if (moved)
      default_lanes(root);
  }

 private:
  void table(Fields& fields, const std::string& key, const std::function<void(const toml::table&)>& take) {
    fields.on(key, [this, take](const toml::node& node, const std::string& k) {
      if (!node.is_table()) ::plant::refuse(node.source(), file_, fmt::format("{} is a table: [{}]", k, k));
      take(*node.as_table());
    });
  }

  template <class T, class Read>
  void take_list(const toml::node& node, const std::string& key, std::vector<T>& to, Read read, bool replaces) {
    const toml::array* array = node.as_array();
    if (array == nullptr || (!array->empty() && !array->is_homogeneous<toml::table>()))
      ::plant::refuse(node.source(), file_, fmt::format("{} is a list of tables: [[{}]]", key, key));
    if (replaces) to.clear();
    for (const toml::node& element : *array) to.push_back(read(*element.as_table()));
  }

  template <class T, class Read>
  void list(Fields& fields, const std::string& key, std::vector<T>& to, Read read, bool replaces = true) {
    fields.on(key, [this, &to, read, replaces](const toml::node& node, const std::string& k) {
      take_list(node, k, to, read, replaces);
    });
  }

  void home(const toml::table& t) {
    Fields fields(t, file_, "home");
    fields.number_to("gantry_m", c_.home.s)
        .number_to("x_m", c_.home.x)
        .number_to("y_m", c_.home.y)
        .number_to("z_m", c_.home.z)
        .number_to("yaw_deg", c_.home.yaw, degree)
        .done();
    if (c_.crane.machine != CraneKind::gantry) return;
    // A gantry stands where its load hangs.
    const toml::node* at = t.get("gantry_m");
    if (at != nullptr && c_.home.s != c_.home.x)
      ::plant::refuse(
          at->source(), file_,
          fmt::format("gantry_m of home is {} m, but a gantry stands at the x_m of its load, {} m; expected "
                      "is the same number, or no gantry_m",
                      c_.home.s, c_.home.x));
    c_.home.s = c_.home.x;
  }

  void box(const toml::table& t, const std::string& what, Box& b) {
    Fields(t, file_, what)
        .range_to("x_m", b.x_min, b.x_max)
        .range_to("y_m", b.y_min, b.y_max)
        .range_to("z_m", b.z_min, b.z_max)
        .done({"x_m", "y_m", "z_m"});
  }

  void spot(const toml::table& t) {
    Pose& p = layout_.spot;
    Fields(t, file_, "the spot")
        .number_to("x_m", p.x)
        .number_to("y_m", p.y)
        .number_to("heading_deg", p.heading, degree)
        .done();
  }

  void warehouse_of(const toml::table& t) {
    Fields(t, file_, "the warehouse")
        .number_to("x_m", layout_.warehouse.x)
        .number_to("y_m", layout_.warehouse.y)
        .number_to("heading_deg", layout_.warehouse.heading, degree)
        .number_to("radius_m", layout_.warehouse_radius)
        .number_to("take_s", layout_.warehouse_take)
        .done();
  }

  ContainerPlace container(const toml::table& t) {
    ContainerPlace p{0.0, layout_.rows.front(), layout_.deck, 0.0, layout_.container_mass};
    double tier = 0.0;
    Fields(t, file_, "a container")
        .number_to("x_m", p.x)
        .number_to("y_m", p.y)
        .number_to("tier", tier)
        .number_to("yaw_deg", p.yaw, degree)
        .number_to("mass_kg", p.mass)
        .done({"x_m", "y_m"});
    if (!(tier >= 0.0 && tier == std::floor(tier)))
      ::plant::refuse(t.source(), file_, fmt::format("a container's tier is 0, 1, 2, ... (got {})", tier));
    p.z += tier * container_height;
    return p;
  }

  Mover post(const toml::table& t) {
    Mover m{0.3, 2.0, {{0.0, 0.0, 0.0}}, false};
    Fields(t, file_, "a post")
        .number_to("x_m", m.path[0].x)
        .number_to("y_m", m.path[0].y)
        .number_to("radius_m", m.radius)
        .number_to("height_m", m.height)
        .done({"x_m", "y_m"});
    return m;
  }

  Mover mover(const toml::table& t) {
    Mover m{0.4, 1.8, {}, false};
    Fields fields(t, file_, "a mover");
    fields.number_to("radius_m", m.radius).number_to("height_m", m.height).flag_to("repeats", m.repeats);
    fields.on("path", [&](const toml::node& node, const std::string& k) {
      const toml::array* array = node.as_array();
      if (array == nullptr || array->empty())
        ::plant::refuse(node.source(), file_, "path of a mover is a list of [time_s, x_m, y_m]");
      for (const toml::node& element : *array) {
        const auto point = fields.numbers(element, k, 3);
        m.path.push_back({point[0], point[1], point[2]});
      }
    });
    fields.done({"path"});
    return m;
  }

  void agv(const toml::table& t) {
    AgvParameters& p = c_.agv;
    Fields(t, file_, "agv")
        .choice_to("drive", {"steered", "differential"}, [&p](std::size_t i) { p.drive = static_cast<AgvDrive>(i); })
        .flag_to("protective_field", p.protective_field)
        .number_to("protective_margin_m", p.protective_margin)
        .number_to("mass_kg", p.mass)
        .number_to("length_m", p.length)
        .number_to("width_m", p.width)
        .number_to("adhesion", p.adhesion)
        .number_to("track_m", p.track)
        .done();
  }

  // to_warehouse and to_spot: pieces [length m, curvature 1/m, speed m/s], each beginning at the end of the last one.
  void lanes_of(const toml::table& t, std::vector<LaneSegment> (&lanes)[2]) {
    Fields fields(t, file_, "lanes");
    static constexpr const char* names[] = {"to_warehouse", "to_spot"};
    for (std::size_t leg = 0; leg < 2; ++leg)
      fields.on(names[leg], [&, leg](const toml::node& node, const std::string& k) {
        const toml::array* array = node.as_array();
        if (array == nullptr || array->empty())
          ::plant::refuse(node.source(), file_, fmt::format("{} is a list of [length_m, curvature_1_m, speed_m_s]", k));
        const Pose& from = leg == 0 ? layout_.spot : layout_.warehouse;
        const Pose& to = leg == 0 ? layout_.warehouse : layout_.spot;
        Pose at = from;
        for (const toml::node& element : *array) {
          const auto piece = fields.numbers(element, k, 3);
          if (!(piece[0] > 0.0 && piece[2] > 0.0))
            ::plant::refuse(element.source(), file_, "a lane's length and speed must be positive");
          lanes[leg].push_back({at.x, at.y, at.heading, piece[0], piece[1], piece[2]});
          at = along(lanes[leg].back(), piece[0]);
        }
        if ((at.x - to.x) * (at.x - to.x) + (at.y - to.y) * (at.y - to.y) > 0.01)
          ::plant::refuse(
              node.source(), file_,
              fmt::format("{} ends at ({:.2f}, {:.2f}) m, not at ({:.2f}, {:.2f})", k, at.x, at.y, to.x, to.y));
        // The next leg begins with the heading of the place, and the queue lies behind it.
        if (std::fabs(wrap_angle(at.heading - to.heading)) > degree)
          ::plant::refuse(node.source(), file_,
                          fmt::format("{} ends with a heading of {:.1f} degrees, not of {:.1f}: that of the {}", k,
                                      wrap_angle(at.heading) / degree, wrap_angle(to.heading) / degree,
                                      leg == 0 ? "warehouse" : "spot"));
      });
    fields.done({"to_warehouse", "to_spot"});
  }

  void default_lanes(const toml::table& root) {
    const double apart = layout_.spot.y - layout_.warehouse.y;
    if (layout_.spot.heading != 0.0 || apart != 24.0)
      ::plant::refuse(
          root.source(), file_,
          "the default loop needs a spot with heading 0 and a warehouse 24 m nearer the land; give [lanes]");
    if (std::fabs(wrap_angle(layout_.warehouse.heading - std::numbers::pi)) > 1e-9) {
      const toml::node* heading = root["warehouse"]["heading_deg"].node();
      ::plant::refuse(
          heading == nullptr ? root.source() : heading->source(), file_,
          fmt::format("heading_deg of the warehouse is {:g}, but the default loop arrives there with a heading of "
                      "180 degrees; expected is 180, no heading_deg, or your own [lanes]",
                      layout_.warehouse.heading / degree));
    }
    layout_.legs = default_loop(layout_, c_.agv_count);
  }

  DockConfig& c_;
  Layout& layout_;
  const std::string& file_;
};

}  // namespace

void apply_layout(DockConfig& config, std::string_view text, const std::string& name) {
  try {
    const toml::table root = io::parse_toml(text, name);
    Reader(config, name).read(root);
  } catch (const toml::parse_error& error) {
    refuse(error.source(), name, std::string(error.description()));
  }
}

void load_layout(DockConfig& config, const std::string& path) {
  apply_layout(config, io::read_file<LayoutError>(path, "the name of a TOML file with a layout"), path);
}

}  // namespace plant
