// One HTTP answer: status, headers that keep a browser on its guard, body. A value in, the bytes of the head
// out.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace deixis {

using SharedBytes = std::shared_ptr<const std::string>;

struct HttpAnswer {
    int status = 200;
    std::string content_type;
    SharedBytes body;                                          ///< null: none
    std::vector<std::pair<std::string, std::string>> headers;  ///< besides those that every answer has
};

/// `{"error": sentence}` with this status.
HttpAnswer error_answer(int status, std::string_view sentence);

/// Status line and headers with the empty line. Every answer but 101 closes the connection and carries the
/// content security policy (own scripts, styles, fonts and connections only) and its companions.
std::string head_of(const HttpAnswer& answer);

/// A strong entity tag, quoted, that depends on the bytes alone.
std::string entity_tag(std::string_view bytes);

}  // namespace deixis
