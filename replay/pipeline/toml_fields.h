// The two visitors of a list of configuration keys: one reads a TOML table into options and collects every problem, the
// other prints options as TOML. A key is named, bounded and explained once, in a function template that takes either
// visitor.
#pragma once

#include <cmath>
#include <concepts>
#include <cstdint>
#include <fmt/format.h>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <toml++/toml.h>
#include <utility>
#include <vector>

namespace risorius {

template <class Enum>
struct Choice {
  std::string_view name;
  Enum value;
};

/// Everything that is wrong with a file, reported together.
class ConfigProblems {
 public:
  void add(std::string_view key, const std::string& problem, const std::string& remedy) {
    lines_.push_back(fmt::format("{}: {} ({})", key, problem, remedy));
  }
  const std::vector<std::string>& lines() const noexcept { return lines_; }

 private:
  std::vector<std::string> lines_;
};

class TomlReader {
 public:
  TomlReader(const toml::table& table, std::string path, ConfigProblems& problems)
      : table_(table), path_(std::move(path)), problems_(problems) {}

  template <class Number>
  void number(std::string_view key, Number& value, double low, double high, std::string_view) {
    const toml::node* node = find(key);
    if (node == nullptr) return;
    const auto found = node->value<double>();
    if (!node->is_number() || !found || !(*found >= low && *found <= high)) {
      problems_.add(full(key), fmt::format("{} is not a number from {} to {}", text_of(*node), low, high),
                    "give a number in this range or leave the key out");
      return;
    }
    if constexpr (std::integral<Number>) {
      if (*found != std::floor(*found)) {
        problems_.add(full(key), fmt::format("{} is not a whole number", text_of(*node)), "give a whole number");
        return;
      }
    }
    value = static_cast<Number>(*found);
  }

  void seconds(std::string_view key, std::int64_t& value_ns, double low, double high, std::string_view meaning) {
    double value_s = static_cast<double>(value_ns) * 1e-9;
    number(key, value_s, low, high, meaning);
    value_ns = std::llround(value_s * 1e9);
  }

  void text(std::string_view key, std::string& value, std::string_view) {
    const toml::node* node = find(key);
    if (node == nullptr) return;
    if (const auto found = node->value<std::string>()) {
      value = *found;
    } else {
      problems_.add(full(key), text_of(*node) + " is not a text", "put it in quotes");
    }
  }

  void flag(std::string_view key, bool& value, std::string_view) {
    const toml::node* node = find(key);
    if (node == nullptr) return;
    if (node->is_boolean()) {
      value = *node->value<bool>();
    } else {
      problems_.add(full(key), text_of(*node) + " is neither true nor false", "give true or false");
    }
  }

  template <class Enum>
  void choice(std::string_view key, Enum& value, std::span<const Choice<Enum>> choices, std::string_view) {
    const toml::node* node = find(key);
    if (node == nullptr) return;
    const auto found = node->value<std::string>();
    std::string names;
    for (const auto& c : choices) {
      if (found && *found == c.name) {
        value = c.value;
        return;
      }
      names += fmt::format("{}\"{}\"", names.empty() ? "" : ", ", c.name);
    }
    problems_.add(full(key), text_of(*node) + " is none of " + names, "choose one of them");
  }

  /// A sub-table; visit(reader) reads it if it is there.
  template <class Visit>
  void table(std::string_view key, Visit visit) {
    const toml::node* node = find(key);
    if (node == nullptr) return;
    if (const toml::table* sub = node->as_table()) {
      TomlReader reader(*sub, full(key), problems_);
      visit(reader);
      reader.refuse_unknown();
    } else {
      problems_.add(full(key), "is not a table", fmt::format("write [{}]", full(key)));
    }
  }

  const toml::node* find(std::string_view key) {
    known_.emplace(key);
    return table_.get(key);
  }

  /// After all keys were visited: what else stands there is a mistake, most often of spelling.
  void refuse_unknown() {
    for (const auto& [key, node] : table_) {
      if (known_.contains(key.str())) continue;
      std::string known;
      for (const auto& name : known_) known += (known.empty() ? "" : ", ") + name;
      problems_.add(full(key.str()), fmt::format("unknown key in line {}", node.source().begin.line),
                    "known here: " + known);
    }
  }

 private:
  std::string full(std::string_view key) const {
    return path_.empty() ? std::string(key) : fmt::format("{}.{}", path_, key);
  }
  static std::string text_of(const toml::node& node) {
    std::ostringstream text;
    node.visit([&](const auto& n) { text << n; });
    return fmt::format("{} in line {}", text.str(), node.source().begin.line);
  }

  const toml::table& table_;
  std::string path_;
  ConfigProblems& problems_;
  std::set<std::string, std::less<>> known_;
};

class TomlPrinter {
 public:
  explicit TomlPrinter(std::string path = "") : path_(std::move(path)) {}

  template <class Number>
  void number(std::string_view key, const Number& value, double low, double high, std::string_view meaning) {
    line(key, fmt::format("{}", value), fmt::format("{}; {:g} to {:g}", meaning, low, high));
  }
  void seconds(std::string_view key, const std::int64_t& value_ns, double low, double high, std::string_view meaning) {
    number(key, static_cast<double>(value_ns) * 1e-9, low, high, meaning);
  }
  void text(std::string_view key, const std::string& value, std::string_view meaning) {
    line(key, quoted(value), meaning);
  }
  void flag(std::string_view key, const bool& value, std::string_view meaning) {
    line(key, value ? "true" : "false", meaning);
  }
  template <class Enum>
  void choice(std::string_view key, const Enum& value, std::span<const Choice<Enum>> choices,
              std::string_view meaning) {
    std::string name, names;
    for (const auto& c : choices) {
      if (c.value == value) name = c.name;
      names += fmt::format("{}{}", names.empty() ? "" : ", ", c.name);
    }
    line(key, quoted(name), fmt::format("{}: {}", meaning, names));
  }
  template <class Visit>
  void table(std::string_view key, Visit visit) {
    TomlPrinter printer(path_.empty() ? std::string(key) : fmt::format("{}.{}", path_, key));
    visit(printer);
    text_ += fmt::format("\n[{}]\n{}", printer.path_, printer.text_);
  }
  void raw(std::string_view text) { text_ += text; }
  const std::string& printed() const noexcept { return text_; }

 private:
  static std::string quoted(const std::string& value) {
    std::ostringstream text;
    text << toml::value<std::string>(value);
    return text.str();
  }
  void line(std::string_view key, const std::string& value, std::string_view meaning) {
    text_ += fmt::format("{:<44} # {}\n", fmt::format("{} = {}", key, value), meaning);
  }

  std::string path_, text_;
};

}  // namespace risorius
