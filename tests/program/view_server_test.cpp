// The server of live views: who is let in, what two pages see of each other, and what a page that
// vanishes leaves.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <fstream>
#include <functional>
#include <memory>
#include <set>
#include <thread>

#include "io/errors.h"
#include "view/page_address.h"
#include "view/page_server.h"
#include "view/view_command.h"

namespace cloudcontact::program::view_server_test {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = beast::websocket;
using boost::asio::ip::tcp;
using std::chrono::milliseconds;
using std::chrono::seconds;

class Served : public PageServer {
 public:
  Served(std::string page, int port, std::chrono::steady_clock::duration patience = kPatience)
      : PageServer(port, patience) {
    serve(std::move(page), isPull);
  }
};

std::string tokenOf(const PageServer& server) {
  const std::string& url = server.url();
  const std::size_t from = url.find('/', 7) + 1;
  return url.substr(from, url.size() - from - 1);
}

std::string hostOf(const PageServer& server) {
  return "127.0.0.1:" + std::to_string(server.port());
}

// All that the server answers to these bytes.
std::string answerOf(const PageServer& server, const std::string& bytes) {
  const int line = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in here{};
  here.sin_family = AF_INET;
  here.sin_port = htons(static_cast<std::uint16_t>(server.port()));
  here.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (connect(line, reinterpret_cast<sockaddr*>(&here), sizeof here) != 0) return "no connection";
  send(line, bytes.data(), bytes.size(), MSG_NOSIGNAL);
  shutdown(line, SHUT_WR);
  std::string answer;
  char block[4096];
  for (ssize_t got; (got = recv(line, block, sizeof block, 0)) > 0;)
    answer.append(block, static_cast<std::size_t>(got));
  close(line);
  return answer;
}

std::string get(const PageServer& server, const std::string& target, const std::string& host,
                const std::string& more = "") {
  return answerOf(server, "GET " + target + " HTTP/1.1\r\nHost: " + host + "\r\n" + more + "\r\n");
}

int statusOf(const std::string& answer) {
  return answer.size() < 12 ? 0 : std::atoi(answer.substr(9, 3).c_str());
}

// An open page.
class Page {
 public:
  Page(const PageServer& server, const std::string& token, const std::string& host,
       const std::string& origin)
      : stream_(io_) {
    tcp::socket& socket = beast::get_lowest_layer(stream_);
    socket.connect({asio::ip::address_v4::loopback(), static_cast<unsigned short>(server.port())});
    stream_.set_option(
        websocket::stream_base::decorator([origin](websocket::request_type& request) {
          request.set(beast::http::field::origin, origin);
        }));
    stream_.handshake(host, "/" + token + "/feed", error_);
  }
  explicit Page(const PageServer& server)
      : Page(server, tokenOf(server), hostOf(server), "http://" + hostOf(server)) {}

  bool isOpen() const { return !error_; }
  void say(const std::string& text) {
    stream_.text(true);
    stream_.write(asio::buffer(text), error_);
  }
  void sayBytes(const std::string& bytes) {
    stream_.binary(true);
    stream_.write(asio::buffer(bytes), error_);
  }
  // The next message; empty where the line is closed.
  std::string hear() {
    beast::flat_buffer buffer;
    stream_.read(buffer, error_);
    return error_ ? "" : beast::buffers_to_string(buffer.data());
  }
  bool wasClosed() const { return error_ == websocket::error::closed; }
  // Without a word, as a browser that crashes.
  void vanish() { beast::get_lowest_layer(stream_).close(); }

 private:
  asio::io_context io_;
  websocket::stream<tcp::socket> stream_;
  beast::error_code error_;
};

// The status of a request for the feed.
int feedStatus(const PageServer& server, const std::string& token, const std::string& host,
               const std::string& origin) {
  return statusOf(get(server, "/" + token + "/feed", host,
                      "Origin: " + origin +
                          "\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n"
                          "Sec-WebSocket-Version: 13\r\n"
                          "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n"));
}

bool waitFor(const std::function<bool()>& what) {
  for (int i = 0; i < 500 && !what(); ++i) std::this_thread::sleep_for(milliseconds(10));
  return what();
}

TEST(PageAddress, AnswersThePageAndItsFeedAlone) {
  const std::string token = "0123456789abcdef";
  const auto answer = [&](PageRequest request) { return answerTo(request, token); };
  const std::string page = "/" + token + "/", feed = page + "feed";
  EXPECT_EQ(answer({"GET", page, "127.0.0.1:80", ""}), PageAnswer::Page);
  EXPECT_EQ(answer({"GET", page + "?x=1", "localhost", ""}), PageAnswer::Page);
  EXPECT_EQ(answer({"POST", page, "localhost:1", ""}), PageAnswer::WrongMethod);
  EXPECT_EQ(answer({"GET", page + "favicon.ico", "localhost", ""}), PageAnswer::NoSuchThing);
  EXPECT_EQ(answer({"GET", feed, "localhost", ""}), PageAnswer::NeedsUpgrade);
  EXPECT_EQ(answer({"GET", feed, "localhost:8", "http://localhost:8", true}), PageAnswer::Feed);
  for (const char* host : {"evil.example", "127.0.0.1.evil.example", "127.0.0.1:80:80", "",
                           "localhost:8x", "127.0.0.2", "[::1]:8"})
    EXPECT_EQ(answer({"GET", page, host, ""}), PageAnswer::WrongHost) << host;
  for (const char* target : {"/", "/0123456789abcdee/", "/0123456789abcdef", "0123456789abcdef/",
                             "//0123456789abcdef/", "/0123456789abcde/", ""})
    EXPECT_EQ(answer({"GET", target, "localhost", ""}), PageAnswer::WrongToken) << target;
  for (const char* origin : {"", "null", "http://evil.example", "https://localhost:8",
                             "http://localhost:9", "http://localhost", "http://127.0.0.1:8"})
    EXPECT_EQ(answer({"GET", feed, "localhost:8", origin, true}), PageAnswer::WrongOrigin)
        << origin;
}

TEST(PageAddress, TokensDiffer) {
  std::set<std::string> seen;
  for (int i = 0; i < 100; ++i) seen.insert(newToken());
  EXPECT_EQ(seen.size(), 100u);
  for (const std::string& token : seen) {
    EXPECT_EQ(token.size(), 32u);
    EXPECT_EQ(token.find_first_not_of("0123456789abcdef"), std::string::npos);
  }
}

TEST(PageServer, GivesThePageToThoseWhoKnowTheToken) {
  const Served server("<p>the page</p>", 0);
  const std::string token = tokenOf(server), host = hostOf(server);
  const std::string page = get(server, "/" + token + "/", host);
  EXPECT_EQ(statusOf(page), 200);
  EXPECT_TRUE(page.ends_with("\r\n\r\n<p>the page</p>"));
  EXPECT_NE(page.find("Cache-Control: no-store"), std::string::npos);
  EXPECT_EQ(statusOf(get(server, "/", host)), 403);
  EXPECT_EQ(statusOf(get(server, "/" + std::string(32, '0') + "/", host)), 403);
  EXPECT_EQ(statusOf(get(server, "/" + token + "/", "evil.example")), 403);
  EXPECT_EQ(statusOf(get(server, "/" + token + "/other", host)), 404);
  EXPECT_EQ(statusOf(get(server, "/" + token + "/feed", host)), 426);
  for (const char* target : {"/", "/wrong/", "/feed"})
    EXPECT_EQ(get(server, target, host).find("the page"), std::string::npos);
}

// A browser that comes while the world is being built waits for its page.
TEST(PageServer, TakesItsPortBeforeItServes) {
  PageServer server(0);
  EXPECT_THROW(PageServer{server.port()}, BadInput);
  std::string page;
  std::thread early([&] { page = get(server, "/" + tokenOf(server) + "/", hostOf(server)); });
  std::this_thread::sleep_for(milliseconds(50));
  server.serve("<p>the page</p>");
  early.join();
  EXPECT_TRUE(page.ends_with("<p>the page</p>"));
}

TEST(PageServer, SurvivesWhatIsNoRequest) {
  const Served server("page", 0);
  const std::string good = "GET /" + tokenOf(server) + "/ HTTP/1.1\r\nHost: localhost\r\n";
  EXPECT_EQ(statusOf(answerOf(server, "rubbish\r\n\r\n")), 400);
  EXPECT_EQ(statusOf(answerOf(server, std::string(3, '\0') + "\x16\x03\x01 tls?\r\n\r\n")), 400);
  EXPECT_EQ(statusOf(answerOf(server, good + "X: " + std::string(100'000, 'x') + "\r\n\r\n")), 400);
  EXPECT_EQ(statusOf(answerOf(server, good + "Content-Length: 9999999\r\n\r\nbody")), 400);
  EXPECT_EQ(answerOf(server, ""), "");
  answerOf(server, good);  // never ends
  EXPECT_EQ(statusOf(answerOf(server, good + "\r\n")), 200);
}

TEST(PageServer, RefusesSocketsOfOtherPages) {
  const Served server("page", 0);
  const std::string token = tokenOf(server), host = hostOf(server), own = "http://" + host;
  EXPECT_EQ(feedStatus(server, token, host, own), 101);
  EXPECT_EQ(feedStatus(server, token, host, "http://evil.example"), 403);
  EXPECT_EQ(feedStatus(server, token, host, ""), 403);
  EXPECT_EQ(feedStatus(server, std::string(32, 'a'), host, own), 403);
  EXPECT_EQ(feedStatus(server, token, "evil.example", "http://evil.example"), 403);
  EXPECT_FALSE(Page(server, token, host, "http://evil.example").isOpen());
  EXPECT_TRUE(waitFor([&] { return server.pages() == 0; }));
  EXPECT_TRUE(Page(server, token, host, own).isOpen());
}

// A browser that loads the page, at its own pace.
class Load {
 public:
  explicit Load(const PageServer& server) : socket_(io_) {
    socket_.open(tcp::v4());
    socket_.set_option(tcp::socket::receive_buffer_size(64 * 1024));
    socket_.connect({asio::ip::address_v4::loopback(), static_cast<unsigned short>(server.port())});
    const std::string request =
        "GET /" + tokenOf(server) + "/ HTTP/1.1\r\nHost: " + hostOf(server) + "\r\n\r\n";
    asio::write(socket_, asio::buffer(request));
  }
  // What comes of these bytes: less where the line is closed.
  std::size_t take(std::size_t bytes) {
    std::string block(bytes, '\0');
    beast::error_code error;
    return asio::read(socket_, asio::buffer(block), error);
  }

 private:
  asio::io_context io_;
  tcp::socket socket_;
};

constexpr std::size_t kLargePage = 12 << 20;
constexpr auto kShortPatience = milliseconds(800);

// The patience is for a part of the page, not for the whole.
TEST(PageServer, ASlowLineGetsTheWholePage) {
  const Served server(std::string(kLargePage, 'x'), 0, kShortPatience);
  Load load(server);
  std::size_t taken = 0, got = 1;
  for (; got > 0; taken += got) {
    got = load.take(kLargePage / 24);
    std::this_thread::sleep_for(kShortPatience / 8);
  }
  EXPECT_GT(taken, kLargePage);  // with its header
}

TEST(PageServer, DropsALineThatDoesNotReadItsPage) {
  const Served server(std::string(kLargePage, 'x'), 0, kShortPatience);
  Load load(server);
  std::this_thread::sleep_for(3 * kShortPatience);
  EXPECT_LT(load.take(kLargePage), kLargePage / 2);
}

// [kB]
long residentMemory() {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;)
    if (long size = 0; word == "VmRSS:" && status >> size) return size;
  return 0;
}

TEST(PageServer, ManyLoadsShareOnePage) {
  const Served server(std::string(kLargePage, 'x'), 0);
  const long before = residentMemory();
  std::vector<std::unique_ptr<Load>> loads;
  for (int i = 0; i < 40; ++i) {
    loads.push_back(std::make_unique<Load>(server));
    EXPECT_EQ(loads.back()->take(1000), 1000u);  // it is on its way
  }
  EXPECT_LT(residentMemory() - before, 10 * static_cast<long>(kLargePage >> 10));
}

TEST(PageServer, TwoPagesHearTheLatestAndAreHeard) {
  Served server("page", 0);
  server.publish(1, "old");
  server.publish(1, "first");
  server.publish(2, "second");
  Page one(server), two(server);
  ASSERT_TRUE(one.isOpen() && two.isOpen());
  for (Page* page : {&one, &two}) {
    EXPECT_EQ(page->hear(), "first");
    EXPECT_EQ(page->hear(), "second");
  }
  one.say("hello");
  auto heard = server.messages(seconds(5));
  ASSERT_EQ(heard.size(), 1u);
  EXPECT_EQ(heard[0].text, "hello");
  two.say("hi");
  const auto other = server.messages(seconds(5));
  ASSERT_EQ(other.size(), 1u);
  EXPECT_NE(other[0].page, heard[0].page);
  server.publish(1, "third");
  EXPECT_EQ(one.hear(), "third");
  EXPECT_EQ(two.hear(), "third");
}

TEST(PageServer, TellsOfAPageThatVanishesAndServesTheOther) {
  Served server("page", 0);
  Page stays(server);
  auto goes = std::make_unique<Page>(server);
  ASSERT_TRUE(waitFor([&] { return server.pages() == 2; }));
  goes->say("I pull");
  const auto said = server.messages(seconds(5));
  ASSERT_EQ(said.size(), 1u);
  goes->vanish();
  const auto gone = server.messages(seconds(5));
  ASSERT_EQ(gone.size(), 1u);
  EXPECT_TRUE(gone[0].isGone);
  EXPECT_EQ(gone[0].page, said[0].page);
  EXPECT_TRUE(waitFor([&] { return server.pages() == 1; }));
  server.publish(0, "still here");
  EXPECT_EQ(stays.hear(), "still here");
}

// A page that does not read gets the latest when it does, and not all in between.
TEST(PageServer, ASlowPageMissesWhatIsOld) {
  Served server("page", 0);
  Page slow(server), quick(server);
  constexpr int kMessages = 200;
  for (int i = 1; i <= kMessages; ++i) {
    std::string bytes(1 << 20, 'x');
    bytes.replace(0, 4, std::to_string(1000 + i));
    server.publish(0, std::move(bytes));
  }
  const auto last = [&](Page& page) {
    int messages = 0;
    for (;;) {
      const std::string heard = page.hear();
      ++messages;
      if (heard.empty() || heard.substr(0, 4) == std::to_string(1000 + kMessages)) break;
    }
    return messages;
  };
  EXPECT_LT(last(slow), kMessages / 2);
  EXPECT_LT(last(quick), kMessages / 2);
}

TEST(PageServer, ClosesPagesThatSayTooMuch) {
  Served server("page", 0);
  Page large(server), many(server), binary(server);
  large.say(std::string(PageServer::kMostBytes + 1, 'x'));
  EXPECT_EQ(large.hear(), "");
  binary.sayBytes("bytes");
  EXPECT_EQ(binary.hear(), "");
  EXPECT_TRUE(binary.wasClosed());
  for (std::size_t i = 0; i <= PageHub::kMostWaiting; ++i) many.say("again");
  EXPECT_EQ(many.hear(), "");
  EXPECT_TRUE(many.wasClosed());
  EXPECT_EQ(server.messages(seconds(0)).size() >= PageHub::kMostWaiting, true);
}

// 60 times a second, while a step takes seconds.
TEST(PageServer, KeepsTheLatestPullOfAHandAlone) {
  Served server("page", 0);
  Page page(server);
  const auto pull = [&](std::size_t to) {
    page.say(R"({"do": "pull", "body": 1, "at": [0, 0, 0], "to": [0, 0, )" + std::to_string(to) +
             "]}");
  };
  constexpr std::size_t kPulls = 4 * PageHub::kMostWaiting;
  for (std::size_t i = 1; i <= kPulls; ++i) pull(i);
  page.say(R"({"do": "release"})");
  for (std::size_t i = 1; i <= kPulls; ++i) pull(1000 + i);
  page.say("the last");
  std::vector<std::string> heard;
  EXPECT_TRUE(waitFor([&] {
    for (const PageMessage& message : server.messages(seconds(0))) heard.push_back(message.text);
    return !heard.empty() && heard.back() == "the last";
  }));
  EXPECT_TRUE(page.isOpen());
  const auto at = [&](const std::string& words) {
    const auto found = std::find_if(heard.begin(), heard.end(), [&](const std::string& text) {
      return text.find(words) != std::string::npos;
    });
    return found - heard.begin();
  };
  EXPECT_LT(at(std::to_string(kPulls) + "]"), at("release"));
  EXPECT_LT(at("release"), at(std::to_string(1000 + kPulls) + "]"));
  EXPECT_LT(at(std::to_string(1000 + kPulls) + "]"), std::ssize(heard));
}

TEST(PageHub, MergesTheLatestOfAPageAlone) {
  PageHub hub;
  hub.mergeThose([](const std::string& text) { return text.starts_with("to "); });
  for (const char* text : {"to 1", "to 2", "cut", "to 3", "cut", "to 4", "to 5"})
    EXPECT_TRUE(hub.put({1, text}));
  EXPECT_TRUE(hub.put({2, "to 6"}));
  EXPECT_TRUE(hub.put({1, "to 7"}));
  EXPECT_TRUE(hub.put({1, "", true}));
  const auto heard = hub.messages(seconds(0));
  std::string all;
  for (const PageMessage& message : heard) all += message.text + ",";
  EXPECT_EQ(all, "to 2,cut,to 3,cut,to 7,to 6,,");
  // What merges with nothing is bounded.
  for (std::size_t i = 0; i < PageHub::kMostWaiting; ++i)
    EXPECT_TRUE(hub.put({1, i % 2 ? "cut" : "to 1"}));
  EXPECT_FALSE(hub.put({1, "cut"}));
  EXPECT_FALSE(hub.put({1, "to 2"}));
  EXPECT_EQ(hub.messages(seconds(0)).size(), PageHub::kMostWaiting);
}

TEST(PageServer, TakesSixteenPages) {
  const Served server("page", 0);
  std::vector<std::unique_ptr<Page>> pages;
  for (int i = 0; i < PageServer::kMostPages; ++i) {
    pages.push_back(std::make_unique<Page>(server));
    EXPECT_TRUE(pages.back()->isOpen());
  }
  EXPECT_EQ(feedStatus(server, tokenOf(server), hostOf(server), "http://" + hostOf(server)), 503);
  EXPECT_FALSE(Page(server).isOpen());
}

TEST(PageServer, APortInUseIsNamed) {
  const Served server("page", 0);
  try {
    const PageServer second(server.port());
    FAIL() << "two servers at one port";
  } catch (const BadInput& error) {
    const std::string words = error.what();
    EXPECT_TRUE(words.starts_with("--port: 127.0.0.1:" + std::to_string(server.port()))) << words;
  }
  EXPECT_THROW(PageServer(65536), BadInput);
  EXPECT_THROW(PageServer(-1), BadInput);
}

// Also the port is free at once.
TEST(PageServer, SaysTheLastWordAndClosesItsPages) {
  auto server = std::make_unique<Served>("page", 0);
  const int port = server->port();
  Page page(*server);
  ASSERT_TRUE(waitFor([&] { return server->pages() == 1; }));
  server->publish(0, "the end");
  std::thread ending([&] { server.reset(); });
  EXPECT_EQ(page.hear(), "the end");
  EXPECT_EQ(page.hear(), "");
  EXPECT_TRUE(page.wasClosed());
  ending.join();
  EXPECT_NO_THROW(PageServer{port});
}

}  // namespace
}  // namespace cloudcontact::program::view_server_test
