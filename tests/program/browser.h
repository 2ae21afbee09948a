// A headless Chromium for tests: sends keys and pointer events, returns screenshots and the
// console. Uses the DevTools protocol over a pipe, so that no port is open.
#pragma once

#include <sys/types.h>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace program_test {

class Browser {
 public:
  // A window of this size [css px]. Throws std::runtime_error if Chromium does not start.
  Browser(int width, int height, const std::vector<std::string>& flags = {});
  ~Browser();
  Browser(const Browser&) = delete;
  Browser& operator=(const Browser&) = delete;

  void open(const std::string& file);
  void openUrl(const std::string& url);
  // The value of a JavaScript expression. Throws if the expression does.
  nlohmann::json value(const std::string& expression);
  // Polls until the expression is true; false if it is not within `seconds`.
  bool becomes(const std::string& expression, double seconds = 30);
  void press(const std::string& key);
  void click(double x, double y);
  // Drags the pointer from one place to another.
  void drag(double x, double y, double toX, double toY);
  // The same in parts.
  void grab(double x, double y);
  void move(double x, double y, double toX, double toY);  // while it holds
  void letGo(double x, double y);
  std::string screenshot();  // a PNG file
  // Errors and warnings of the console, exceptions, and the browser's own complaints.
  const std::vector<std::string>& complaints() const { return complaints_; }

 private:
  nlohmann::json call(const std::string& method, const nlohmann::json& parameters,
                      bool toPage = true);
  nlohmann::json message();
  void listen(const nlohmann::json& event);
  void pointer(const char* type, double x, double y, int buttons);

  pid_t process_ = -1;
  int in_ = -1, out_ = -1;
  int calls_ = 0;
  std::string profile_, session_, unread_;
  std::vector<std::string> complaints_;
};

// For PNG files: the share of pixels that differ between two pictures of one size, and the number
// of colors in a picture.
double difference(const std::string& a, const std::string& b);
std::size_t colors(const std::string& png);

}  // namespace program_test
