// What the I/O thread does again and again goes on whatever is thrown.
#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>
#include <new>
#include <string>
#include <vector>

#include "server/net/listener.h"
#include "server/net/repeater.h"
#include "tests/server/net/client.h"

namespace foreland::server {
namespace {

TEST(Repeater, GoesOnWhateverATurnThrows) {
  boost::asio::io_context io;
  std::vector<std::string> failures;
  Repeater repeater(io, [&](const char* what) { failures.emplace_back(what); });
  int turns = 0;
  repeater.start(Duration{1}, [&] {
    ++turns;
    if (turns == 2) throw std::bad_alloc();
    if (turns == 3) throw turns;
    return turns < 5;
  });
  repeater.resume();  // does nothing: the next turn is waited for
  io.run();
  EXPECT_EQ(turns, 5);
  EXPECT_EQ(failures, (std::vector<std::string>{"std::bad_alloc", "an unknown exception"}));
}

TEST(Repeater, GoesOnWhereItsFailureWasThrownOn) {
  boost::asio::io_context io;
  Repeater repeater(io, [&](const char*) { throw std::bad_alloc(); });
  int turns = 0;
  repeater.start(Duration{1}, [&] {
    if (++turns == 1) throw std::bad_alloc();
    return turns < 3;
  });
  EXPECT_THROW(io.run(), std::bad_alloc);
  io.restart();
  repeater.resume();
  io.run();
  EXPECT_EQ(turns, 3);
}

TEST(Repeater, TakesNoTurnOnceItIsStopped) {
  boost::asio::io_context io;
  Repeater repeater(io, {});
  int turns = 0;
  repeater.start(Duration{1}, [&] { return ++turns > 0; });
  repeater.stop();
  repeater.resume();
  io.run();
  EXPECT_EQ(turns, 0);
}

TEST(Listener, AcceptsOnAfterWhatOneConnectionThrew) {
  boost::asio::io_context io;
  int connections = 0;
  Listener listener(io, {.on_connection =
                             [&](boost::asio::ip::tcp::socket) {
                               if (++connections == 1) throw std::bad_alloc();
                               listener.close();
                             },
                         .on_trouble = {}});
  ASSERT_TRUE(listener.open({.port = 0}, "--listen").ok());
  listener.accept();
  const test::Socket first(listener.port()), second(listener.port());
  EXPECT_THROW(io.run(), std::bad_alloc);
  io.restart();
  listener.accept();
  listener.accept();  // does nothing
  io.run();
  EXPECT_EQ(connections, 2);
}

}  // namespace
}  // namespace foreland::server
