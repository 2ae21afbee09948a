// Sockets of a PageServer. All of it runs in one thread, by callbacks.
#include "view/page_server.h"

#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <functional>
#include <optional>
#include <set>
#include <thread>
#include <utility>

#include "io/errors.h"
#include "view/page_address.h"

namespace cloudcontact::program {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using boost::asio::ip::tcp;
using Error = beast::error_code;
using Request = http::request<http::empty_body>;
using Answer = http::span_body<const char>;
using Text = std::shared_ptr<const std::string>;

constexpr auto kSilence = std::chrono::seconds(30);  // of a page, which then answers pings or ends
constexpr auto kFarewell = std::chrono::seconds(1);  // for pages to close at the end
constexpr auto kPause = std::chrono::milliseconds(100);  // after a connection that failed
constexpr std::uint32_t kMostHeader = 16 * 1024;         // [bytes]
// Of a connection, in the system's hands [bytes]. Of more, a slow line would take longer than the
// patience before the system asks for the next.
constexpr int kMostUnsent = 128 * 1024;

class PageLine;

// What the connections share.
struct Service {
  Text page;  // one for all
  std::string token;
  std::chrono::steady_clock::duration patience;
  PageHub hub;
  asio::io_context io{1};
  std::set<std::shared_ptr<PageLine>> lines;
  std::atomic<int> open{0};
  int numbers = 0;  // of pages so far
  bool isClosing = false;

  void add(const std::shared_ptr<PageLine>& line) {
    lines.insert(line);
    open = static_cast<int>(lines.size());
  }
  void remove(const std::shared_ptr<PageLine>& line) {
    lines.erase(line);
    open = static_cast<int>(lines.size());
    if (isClosing && lines.empty()) io.stop();
  }
};

// An open page.
class PageLine : public std::enable_shared_from_this<PageLine> {
 public:
  PageLine(Service& service, beast::tcp_stream stream, int number)
      : service_(service), stream_(std::move(stream)), number_(number) {}

  void start(const Request& request) {
    beast::get_lowest_layer(stream_).expires_never();
    stream_.set_option(websocket::stream_base::timeout{service_.patience, kSilence, true});
    stream_.read_message_max(PageServer::kMostBytes);
    stream_.binary(true);
    stream_.async_accept(request, [self = shared_from_this()](Error error) {
      if (error) return self->end();
      self->isOpen_ = true;
      self->read();
      self->send();
    });
  }

  // The next topic, where none is on its way.
  void send() {
    if (!isOpen_ || sending_) return;
    sending_ = service_.hub.next(progress_);
    if (!sending_) {
      if (service_.isClosing) close(websocket::close_code::going_away);
      return;
    }
    stream_.async_write(asio::buffer(*sending_),
                        [self = shared_from_this()](Error error, std::size_t) {
                          self->sending_.reset();
                          if (error) return self->end();
                          self->send();
                        });
  }

 private:
  void read() {
    stream_.async_read(heard_, [self = shared_from_this()](Error error, std::size_t) {
      if (error) return self->end();
      PageMessage message{self->number_, beast::buffers_to_string(self->heard_.data())};
      self->heard_.clear();
      if (!self->stream_.got_text() || !self->service_.hub.put(std::move(message)))
        self->close(websocket::close_code::policy_error);
      else
        self->read();
    });
  }

  void close(websocket::close_code why) {
    if (!std::exchange(isOpen_, false)) return;
    stream_.async_close(why, [self = shared_from_this()](Error) { self->end(); });
  }

  void end() {
    isOpen_ = false;
    if (std::exchange(isGone_, true)) return;
    beast::get_lowest_layer(stream_).close();
    service_.hub.put({number_, "", true});
    service_.remove(shared_from_this());
  }

  Service& service_;
  websocket::stream<beast::tcp_stream> stream_;
  int number_;
  PageProgress progress_;
  beast::flat_buffer heard_;
  std::shared_ptr<const std::string> sending_;
  bool isOpen_ = false, isGone_ = false;
};

struct Words {
  http::status status;
  const char* text;
};

Words wordsOf(PageAnswer answer) {
  switch (answer) {
    case PageAnswer::WrongHost:
      return {http::status::forbidden, "This page is for 127.0.0.1 and localhost alone.\n"};
    case PageAnswer::WrongToken:
      return {http::status::forbidden,
              "The address lacks this run's token; open the one that the program printed.\n"};
    case PageAnswer::WrongOrigin:
      return {http::status::forbidden, "Only the program's own page may connect here.\n"};
    case PageAnswer::WrongMethod:
      return {http::status::method_not_allowed, "Only GET is known here.\n"};
    case PageAnswer::NeedsUpgrade:
      return {http::status::upgrade_required, "This address is for a WebSocket.\n"};
    default:
      return {http::status::not_found, "There is nothing at this address.\n"};
  }
}

// A connection until it is answered.
class Visit : public std::enable_shared_from_this<Visit> {
 public:
  Visit(Service& service, tcp::socket socket) : service_(service), stream_(std::move(socket)) {
    parser_.header_limit(kMostHeader);
    parser_.body_limit(0);
  }

  void start() {
    stream_.expires_after(service_.patience);
    http::async_read(
        stream_, buffer_, parser_, [self = shared_from_this()](Error error, std::size_t) {
          if (!error) return self->answer();
          // Not where the other end went away, or said nothing in time.
          const auto& ofHttp = http::make_error_code(http::error::bad_method).category();
          if (error.category() == ofHttp && error != http::error::end_of_stream)
            self->refuse(http::status::bad_request, "This is no request.\n");
        });
  }

 private:
  void answer() {
    const Request& request = parser_.get();
    const auto text = [](beast::string_view v) { return std::string_view(v.data(), v.size()); };
    const PageAnswer answer = answerTo(
        {text(request.method_string()), text(request.target()), text(request[http::field::host]),
         text(request[http::field::origin]), websocket::is_upgrade(request)},
        service_.token);
    if (answer == PageAnswer::Page) return respond(http::status::ok, service_.page);
    if (answer == PageAnswer::Feed) return connect(request);
    const Words words = wordsOf(answer);
    refuse(words.status, words.text);
  }

  void connect(const Request& request) {
    if (service_.isClosing || service_.lines.size() >= PageServer::kMostPages)
      return refuse(http::status::service_unavailable, "Too many pages are open.\n");
    const auto line = std::make_shared<PageLine>(service_, std::move(stream_), ++service_.numbers);
    service_.add(line);
    line->start(request);
  }

  void refuse(http::status status, const char* text) {
    respond(status, std::make_shared<const std::string>(text));
  }

  void respond(http::status status, Text text) {
    text_ = std::move(text);
    response_.result(status);
    response_.set(http::field::content_type, status == http::status::ok
                                                 ? "text/html; charset=utf-8"
                                                 : "text/plain; charset=utf-8");
    response_.set(http::field::cache_control, "no-store");
    response_.set("X-Content-Type-Options", "nosniff");
    response_.set("Referrer-Policy", "no-referrer");
    if (status == http::status::method_not_allowed) response_.set(http::field::allow, "GET");
    response_.keep_alive(false);
    response_.body() = {text_->data(), text_->size()};
    response_.prepare_payload();
    write();
  }

  // What the line takes at once, then the rest: the patience is for each part, as a page may take
  // minutes over a slow line.
  void write() {
    stream_.expires_after(service_.patience);
    http::async_write_some(stream_, rest_, [self = shared_from_this()](Error error, std::size_t) {
      if (!error && !self->rest_.is_done()) return self->write();
      self->stream_.socket().shutdown(tcp::socket::shutdown_send, error);
    });
  }

  Service& service_;
  beast::tcp_stream stream_;
  beast::flat_buffer buffer_{kMostHeader + 1024};
  http::request_parser<http::empty_body> parser_;
  Text text_;  // that response_ points to
  http::response<Answer> response_;
  http::response_serializer<Answer> rest_{response_};
};

}  // namespace

struct PageServer::State {
  State(int port, std::chrono::steady_clock::duration patience) {
    service.patience = patience;
    service.token = newToken();
    listen(port);
    url = "http://127.0.0.1:" + std::to_string(here) + "/" + service.token + "/";
  }
  ~State() {
    if (!thread.joinable()) return;
    asio::post(service.io, [this] { close(); });
    thread.join();
  }

  void serve(std::string page) {
    service.page = std::make_shared<const std::string>(std::move(page));
    accept();
    thread = std::thread([this] { run(); });
  }

  void listen(int port) {
    if (port < 0 || port > 65535)
      throw BadInput("--port: must be from 1 to 65535, or 0 for a free one, not " +
                     std::to_string(port));
    Error error;
    const tcp::endpoint there(asio::ip::address_v4::loopback(), static_cast<unsigned short>(port));
    acceptor.open(there.protocol(), error);
    if (!error) acceptor.set_option(tcp::acceptor::reuse_address(true), error);
    if (!error) acceptor.bind(there, error);
    if (!error) acceptor.listen(asio::socket_base::max_listen_connections, error);
    if (error)
      throw BadInput("--port: 127.0.0.1:" + std::to_string(port) + " cannot be had (" +
                     error.message() + "); give another, or leave it out for a free one");
    here = acceptor.local_endpoint().port();
  }

  // A connection that fails by an exception, for want of memory, ends alone.
  void run() {
    for (;;) try {
        service.io.run();
        return;
      } catch (const std::exception&) {
      }
  }

  void accept() {
    acceptor.async_accept([this](Error error, tcp::socket socket) {
      if (service.isClosing) return;
      if (!error) {
        socket.set_option(tcp::no_delay(true), error);
        socket.set_option(tcp::socket::send_buffer_size(kMostUnsent), error);
        std::make_shared<Visit>(service, std::move(socket))->start();
        return accept();
      }
      timer.expires_after(kPause);  // no file left, or the like
      timer.async_wait([this](Error) { accept(); });
    });
  }

  void wake() {
    if (isWaking.exchange(true)) return;
    asio::post(service.io, [this] {
      isWaking = false;
      for (const auto& line : std::set(service.lines)) line->send();
    });
  }

  void close() {
    service.isClosing = true;
    Error ignored;
    acceptor.close(ignored);
    if (service.lines.empty()) return service.io.stop();
    for (const auto& line : std::set(service.lines)) line->send();
    timer.expires_after(kFarewell);
    timer.async_wait([this](Error error) {
      if (!error) service.io.stop();
    });
  }

  Service service;
  tcp::acceptor acceptor{service.io};
  asio::steady_timer timer{service.io};
  int here = 0;  // port
  std::string url;
  std::atomic<bool> isWaking{false};
  std::thread thread;
};

PageServer::PageServer(int port, std::chrono::steady_clock::duration patience)
    : state_(std::make_unique<State>(port, patience)) {}
PageServer::~PageServer() = default;

void PageServer::serve(std::string page, std::function<bool(const std::string&)> merges) {
  state_->service.hub.mergeThose(std::move(merges));
  state_->serve(std::move(page));
}

const std::string& PageServer::url() const {
  return state_->url;
}
int PageServer::port() const {
  return state_->here;
}
int PageServer::pages() const {
  return state_->service.open;
}
void PageServer::publish(int topic, std::string bytes) {
  state_->service.hub.publish(topic, std::move(bytes));
  state_->wake();
}
std::vector<PageMessage> PageServer::messages(std::chrono::steady_clock::duration patience) {
  return state_->service.hub.messages(patience);
}

}  // namespace cloudcontact::program
