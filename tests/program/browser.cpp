// Messages are JSON texts that end in a zero byte, in both directions.
#include "program/browser.h"

#include <cairo.h>
#include <fcntl.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <memory>
#include <set>
#include <stdexcept>
#include <thread>

namespace program_test {
namespace {

using Json = nlohmann::json;
constexpr int kPatience = 120'000;  // timeout of an answer [ms]

std::vector<std::string> commandLine(int width, int height, const std::string& profile,
                                     const std::vector<std::string>& flags) {
  std::vector<std::string> words = {
      "chromium",
      "--headless=new",
      "--no-sandbox",  // needed as root
      "--remote-debugging-pipe",
      "--use-angle=swiftshader",
      "--enable-unsafe-swiftshader",
      "--ignore-gpu-blocklist",
      "--hide-scrollbars",
      "--no-first-run",
      "--disable-background-networking",
      "--disable-dev-shm-usage",  // small in containers
      "--user-data-dir=" + profile,
      "--window-size=" + std::to_string(width) + "," + std::to_string(height)};
  words.insert(words.end(), flags.begin(), flags.end());
  return words;
}

// In the child: Chromium reads from 3 and writes to 4; all else is silenced.
[[noreturn]] void become(const std::vector<std::string>& words, int read, int write) {
  const int quiet = open("/dev/null", O_RDWR);
  dup2(quiet, STDOUT_FILENO);
  dup2(quiet, STDERR_FILENO);
  const int first = fcntl(read, F_DUPFD, 10), second = fcntl(write, F_DUPFD, 10);
  dup2(first, 3);
  dup2(second, 4);
  std::vector<char*> raw;
  for (const std::string& word : words) raw.push_back(const_cast<char*>(word.c_str()));
  raw.push_back(nullptr);
  execvp(raw[0], raw.data());
  _exit(127);
}

std::string fromBase64(const std::string& text) {
  static const std::string letters =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  unsigned bits = 0;
  int held = 0;
  for (const char c : text) {
    const std::size_t value = letters.find(c);
    if (value == std::string::npos) break;
    bits = bits << 6 | static_cast<unsigned>(value);
    held += 6;
    if (held >= 8) out += static_cast<char>(bits >> (held -= 8) & 255);
  }
  return out;
}

using Surface = std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)>;

Surface decoded(const std::string& png) {
  struct Source {
    const std::string& bytes;
    std::size_t at;
  } source{png, 0};
  const auto read = [](void* from, unsigned char* to, unsigned size) {
    auto& s = *static_cast<Source*>(from);
    if (s.at + size > s.bytes.size()) return CAIRO_STATUS_READ_ERROR;
    std::memcpy(to, s.bytes.data() + s.at, size);
    s.at += size;
    return CAIRO_STATUS_SUCCESS;
  };
  Surface surface(cairo_image_surface_create_from_png_stream(read, &source),
                  &cairo_surface_destroy);
  if (cairo_surface_status(surface.get()) != CAIRO_STATUS_SUCCESS)
    throw std::runtime_error("no picture");
  return surface;
}

template <class Work>  // work(pointer to a pixel's four bytes, its number)
void eachPixel(cairo_surface_t* surface, Work work) {
  const int width = cairo_image_surface_get_width(surface);
  const int height = cairo_image_surface_get_height(surface);
  const unsigned char* data = cairo_image_surface_get_data(surface);
  const int stride = cairo_image_surface_get_stride(surface);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) work(data + y * stride + 4 * x, y * width + x);
}

}  // namespace

Browser::Browser(int width, int height, const std::vector<std::string>& flags) {
  profile_ = (std::filesystem::temp_directory_path() / "cloudcontact-browser.XXXXXX").string();
  if (mkdtemp(profile_.data()) == nullptr) throw std::runtime_error("no temporary folder");
  int toChild[2], fromChild[2];
  if (pipe2(toChild, O_CLOEXEC) != 0 || pipe2(fromChild, O_CLOEXEC) != 0)
    throw std::runtime_error("no pipe");
  signal(SIGPIPE, SIG_IGN);  // without chromium, writing fails with a message instead
  const auto words = commandLine(width, height, profile_, flags);
  process_ = fork();
  if (process_ == 0) become(words, toChild[0], fromChild[1]);
  close(toChild[0]);
  close(fromChild[1]);
  in_ = toChild[1];
  out_ = fromChild[0];
  const Json target = call("Target.createTarget", {{"url", "about:blank"}}, false)["targetId"];
  session_ =
      call("Target.attachToTarget", {{"targetId", target}, {"flatten", true}}, false)["sessionId"];
  for (const char* domain : {"Page.enable", "Runtime.enable", "Log.enable"})
    call(domain, Json::object());
  call("Emulation.setDeviceMetricsOverride",
       {{"width", width}, {"height", height}, {"deviceScaleFactor", 1}, {"mobile", width < 600}});
}

Browser::~Browser() {
  close(in_);
  close(out_);
  for (int i = 0; i < 50; ++i) {
    if (waitpid(process_, nullptr, WNOHANG) != 0) break;
    if (i == 40) kill(process_, SIGKILL);
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  std::error_code error;
  std::filesystem::remove_all(profile_, error);
}

Json Browser::message() {
  std::size_t end;
  while ((end = unread_.find('\0')) == std::string::npos) {
    pollfd waiting{out_, POLLIN, 0};
    if (poll(&waiting, 1, kPatience) <= 0) throw std::runtime_error("the browser does not answer");
    char bytes[65536];
    const ssize_t count = read(out_, bytes, sizeof bytes);
    if (count <= 0)
      throw std::runtime_error("chromium is not there or went away; script/bootstrap installs it");
    unread_.append(bytes, static_cast<std::size_t>(count));
  }
  const Json text = Json::parse(unread_.substr(0, end));
  unread_.erase(0, end + 1);
  return text;
}

Json Browser::call(const std::string& method, const Json& parameters, bool toPage) {
  Json request = {{"id", ++calls_}, {"method", method}, {"params", parameters}};
  if (toPage) request["sessionId"] = session_;
  const std::string text = request.dump() + '\0';
  for (std::size_t done = 0; done < text.size();) {
    const ssize_t count = write(in_, text.data() + done, text.size() - done);
    if (count <= 0) throw std::runtime_error("the browser went away");
    done += static_cast<std::size_t>(count);
  }
  for (;;) {
    const Json answer = message();
    if (answer.value("id", 0) != calls_) {
      listen(answer);
      continue;
    }
    if (answer.contains("error")) throw std::runtime_error(method + ": " + answer["error"].dump());
    return answer["result"];
  }
}

void Browser::listen(const Json& event) {
  const std::string method = event.value("method", "");
  if (method == "Runtime.exceptionThrown")
    complaints_.push_back(event["params"]["exceptionDetails"].dump());
  if (method == "Log.entryAdded" && event["params"]["entry"]["level"] != "verbose" &&
      event["params"]["entry"]["level"] != "info")
    complaints_.push_back(event["params"]["entry"].dump());
  if (method == "Runtime.consoleAPICalled") {
    const std::string type = event["params"]["type"];
    if (type == "error" || type == "warning" || type == "assert")
      complaints_.push_back(event["params"]["args"].dump());
  }
}

void Browser::open(const std::string& file) {
  openUrl("file://" + std::filesystem::absolute(file).string());
}

void Browser::openUrl(const std::string& url) {
  call("Page.navigate", {{"url", url}});
}

Json Browser::value(const std::string& expression) {
  const Json result =
      call("Runtime.evaluate",
           {{"expression", expression}, {"returnByValue", true}, {"awaitPromise", true}});
  if (result.contains("exceptionDetails"))
    throw std::runtime_error(expression + ": " + result["exceptionDetails"].dump());
  return result["result"].contains("value") ? result["result"]["value"] : Json();
}

bool Browser::becomes(const std::string& expression, double seconds) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  do {
    try {
      if (value("!!(" + expression + ")") == true) return true;
    } catch (const std::runtime_error&) {  // the page is loading
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  } while (std::chrono::steady_clock::now() < end);
  return false;
}

void Browser::press(const std::string& key) {
  Json event = {{"type", "keyDown"}, {"key", key}};
  if (key.size() == 1) event["text"] = key;
  call("Input.dispatchKeyEvent", event);
  call("Input.dispatchKeyEvent", {{"type", "keyUp"}, {"key", key}});
}

void Browser::pointer(const char* type, double x, double y, int buttons) {
  call("Input.dispatchMouseEvent", {{"type", type},
                                    {"x", x},
                                    {"y", y},
                                    {"button", "left"},
                                    {"buttons", buttons},
                                    {"clickCount", 1}});
}

void Browser::click(double x, double y) {
  pointer("mousePressed", x, y, 1);
  pointer("mouseReleased", x, y, 0);
}

void Browser::grab(double x, double y) {
  pointer("mousePressed", x, y, 1);
}

void Browser::move(double x, double y, double toX, double toY) {
  for (int i = 1; i <= 4; ++i)
    pointer("mouseMoved", x + (toX - x) * i / 4, y + (toY - y) * i / 4, 1);
}

void Browser::letGo(double x, double y) {
  pointer("mouseReleased", x, y, 0);
}

void Browser::drag(double x, double y, double toX, double toY) {
  grab(x, y);
  move(x, y, toX, toY);
  letGo(toX, toY);
}

std::string Browser::screenshot() {
  // Waits two frames, so that a key's effect is drawn.
  value("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))");
  return fromBase64(call("Page.captureScreenshot", {{"format", "png"}})["data"]);
}

double difference(const std::string& a, const std::string& b) {
  const Surface first = decoded(a), second = decoded(b);
  std::vector<const unsigned char*> pixels;
  eachPixel(first.get(), [&](const unsigned char* p, int) { pixels.push_back(p); });
  std::size_t differ = 0;
  eachPixel(second.get(), [&](const unsigned char* p, int number) {
    int most = 0;
    for (int k = 0; k < 3; ++k)
      most = std::max(most, std::abs(p[k] - pixels.at(static_cast<std::size_t>(number))[k]));
    differ += most > 12;
  });
  return double(differ) / double(pixels.size());
}

std::size_t colors(const std::string& png) {
  const Surface surface = decoded(png);
  std::set<unsigned> seen;
  eachPixel(surface.get(), [&](const unsigned char* p, int) {
    seen.insert(unsigned(p[0]) | unsigned(p[1]) << 8 | unsigned(p[2]) << 16);
  });
  return seen.size();
}

}  // namespace program_test
