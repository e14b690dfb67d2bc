// Header by lines, then the data value by value, as text or as bytes of either order.
#include "appliance/parts/ply_check.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <optional>
#include <utility>
#include <vector>

namespace deixis {
namespace {

struct Type {
    size_t size = 0;
    bool is_signed = false, real = false;
};

std::optional<Type> type_named(std::string_view name) {
    struct Named {
        std::string_view old_name, new_name;
        Type type;
    };
    static constexpr std::array<Named, 8> table = {{{"char", "int8", {1, true, false}},
                                                    {"uchar", "uint8", {1, false, false}},
                                                    {"short", "int16", {2, true, false}},
                                                    {"ushort", "uint16", {2, false, false}},
                                                    {"int", "int32", {4, true, false}},
                                                    {"uint", "uint32", {4, false, false}},
                                                    {"float", "float32", {4, true, true}},
                                                    {"double", "float64", {8, true, true}}}};
    for (const Named& named : table)
        if (name == named.old_name || name == named.new_name) return named.type;
    return std::nullopt;
}

struct Property {
    std::string_view name;
    Type type;
    std::optional<Type> length;  ///< of a list: the type of its count
};

struct Element {
    std::string_view name;
    uint64_t count = 0;
    std::vector<Property> properties;
};

enum class Encoding { text, little, big };

struct Header {
    std::optional<Encoding> encoding;
    std::vector<Element> elements;
    uint64_t vertices = 0;
};

template <class T>
bool parse(std::string_view text, T& value) {
    if (text.starts_with('+')) text.remove_prefix(1);
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc() && end == text.data() + text.size();
}

bool is_space(char c) {
    return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\v' || c == '\f';
}

std::string_view next_word(std::string_view& text) {
    size_t begin = 0;
    while (begin < text.size() && is_space(text[begin])) ++begin;
    size_t end = begin;
    while (end < text.size() && !is_space(text[end])) ++end;
    const std::string_view word = text.substr(begin, end - begin);
    text.remove_prefix(end);
    return word;
}

/// The next line without its end; nullopt when none is left.
std::optional<std::string_view> next_line(std::string_view& text) {
    const size_t end = text.find_first_of("\r\n");
    if (end == std::string_view::npos) return std::nullopt;
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(end + (text.substr(end).starts_with("\r\n") ? 2 : 1));
    return line;
}

bool take_property(std::string_view line, Header& header) {
    if (header.elements.empty()) return false;
    Property property;
    std::string_view word = next_word(line);
    if (word == "list") {
        property.length = type_named(next_word(line));
        if (!property.length || property.length->real) return false;
        word = next_word(line);
    }
    const auto type = type_named(word);
    property.name = next_word(line);
    if (!type || property.name.empty() || !next_word(line).empty()) return false;
    property.type = *type;
    header.elements.back().properties.push_back(property);
    return true;
}

bool take_header_line(std::string_view line, Header& header) {
    const std::string_view key = next_word(line);
    if (key.empty() || key == "comment" || key == "obj_info") return true;
    if (key == "property") return take_property(line, header);
    if (key == "format") {
        const std::string_view encoding = next_word(line);
        if (encoding == "ascii") header.encoding = Encoding::text;
        if (encoding == "binary_little_endian") header.encoding = Encoding::little;
        if (encoding == "binary_big_endian") header.encoding = Encoding::big;
        return header.encoding && next_word(line) == "1.0";
    }
    if (key != "element") return false;
    Element element;
    element.name = next_word(line);
    if (element.name.empty() || !parse(next_word(line), element.count) || !next_word(line).empty())
        return false;
    if (element.name == "vertex") header.vertices = element.count;
    header.elements.push_back(std::move(element));
    return true;
}

bool has_property(const Element& element, std::string_view name) {
    return std::any_of(element.properties.begin(), element.properties.end(),
                       [&](const Property& p) { return p.name == name && !p.length; });
}

/// Leaves `rest` behind the header; a complaint without the file's name, empty when all is well.
std::string take_header(std::string_view& rest, Header& header) {
    if (next_line(rest) != "ply") return "the file does not begin with the line \"ply\"";
    for (int number = 2;; ++number) {
        const auto line = next_line(rest);
        if (!line) return "the PLY header has no end";
        if (*line == "end_header") break;
        if (!take_header_line(*line, header))
            return "line " + std::to_string(number) + " of the PLY header cannot be understood";
    }
    if (!header.encoding) return "the PLY header names no format";
    for (const std::string_view name : {"vertex", "face"})
        if (std::count_if(header.elements.begin(), header.elements.end(),
                          [&](const Element& e) { return e.name == name; }) != 1)
            return "the PLY header has not exactly one element \"" + std::string(name) + "\"";
    for (const Element& element : header.elements) {
        if (element.properties.empty()) return "an element of the PLY header has no property";
        if (element.name == "vertex" &&
            !(has_property(element, "x") && has_property(element, "y") && has_property(element, "z")))
            return "the vertices of the PLY file have no x, y and z";
    }
    return "";
}

/// Takes values off the front of the data, one after the other.
class Values {
  public:
    Values(std::string_view data, Encoding encoding) : data_(data), encoding_(encoding) {}

    /// Each element of a text stands in a line of its own: readers go by lines.
    void begin_element() {
        if (encoding_ != Encoding::text) return;
        do {
            data_.remove_prefix(std::min(data_.size(), data_.find_first_not_of("\r\n")));
            const size_t end = std::min(data_.size(), data_.find_first_of("\r\n"));
            line_ = data_.substr(0, end);
            data_.remove_prefix(end);
        } while (!data_.empty() && line_.find_first_not_of(" \t\v\f") == std::string_view::npos);
    }

    /// The next whole number; nullopt when the data ends before it or holds something else.
    std::optional<int64_t> whole(Type type) {
        int64_t value = 0;
        if (encoding_ == Encoding::text) {
            if (!parse(next_word(line_), value)) return std::nullopt;
            return value;
        }
        if (data_.size() < type.size) return std::nullopt;
        uint64_t bits = 0;
        for (size_t i = 0; i < type.size; ++i) {
            const size_t at = encoding_ == Encoding::big ? i : type.size - 1 - i;
            bits = bits << 8 | static_cast<unsigned char>(data_[at]);
        }
        data_.remove_prefix(type.size);
        const unsigned unused = 64 - 8 * static_cast<unsigned>(type.size);
        return type.is_signed ? static_cast<int64_t>(bits << unused) >> unused : static_cast<int64_t>(bits);
    }

    /// Steps over one value; false as above.
    bool skip(Type type) {
        if (encoding_ == Encoding::text) {
            double value = 0;
            return parse(next_word(line_), value);
        }
        if (data_.size() < type.size) return false;
        data_.remove_prefix(type.size);
        return true;
    }

  private:
    std::string_view data_, line_;
    Encoding encoding_;
};

enum class Finding { good, cut, no_vertex };

Finding walk_list(Values& values, const Property& property, uint64_t vertices) {
    const auto length = values.whole(*property.length);
    if (!length || *length < 0) return Finding::cut;
    const bool corners = property.name == "vertex_indices" || property.name == "vertex_index";
    for (int64_t i = 0; i < *length; ++i) {
        if (!corners) {
            if (!values.skip(property.type)) return Finding::cut;
            continue;
        }
        const auto corner = values.whole(property.type);
        if (!corner) return Finding::cut;
        if (*corner < 0 || static_cast<uint64_t>(*corner) >= vertices) return Finding::no_vertex;
    }
    return Finding::good;
}

Finding walk_one(Values& values, const Element& element, uint64_t vertices) {
    values.begin_element();
    for (const Property& property : element.properties) {
        if (!property.length) {
            if (!values.skip(property.type)) return Finding::cut;
        } else if (const Finding found = walk_list(values, property, vertices); found != Finding::good) {
            return found;
        }
    }
    return Finding::good;
}

}  // namespace

Result<void> check_ply(std::string_view bytes, const std::string& file) {
    const auto unreadable = [&](const std::string& why) {
        return fail(file + ": the mesh cannot be read (" + why + ").");
    };
    Header header;
    if (const std::string complaint = take_header(bytes, header); !complaint.empty())
        return unreadable(complaint);
    Values values(bytes, *header.encoding);
    for (const Element& element : header.elements)
        for (uint64_t i = 0; i < element.count; ++i) {
            const Finding found = walk_one(values, element, header.vertices);
            if (found == Finding::good) continue;
            const std::string which =
                (element.name == "vertex" || element.name == "face" ? std::string(element.name)
                                                                    : std::string("element")) +
                " " + std::to_string(i) + " of " + std::to_string(element.count);
            return unreadable(which + (found == Finding::cut ? " is cut short or damaged"
                                                             : " has a corner that is no vertex"));
        }
    return {};
}

}  // namespace deixis
