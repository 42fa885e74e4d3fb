#include "lab/apps/bench_link.h"
#include "apps/options/options.h"

#include <bit>

namespace foreland::apps {

void addLinkOptions(CLI::App& app, LinkArguments& args, const char* usual) {
  args.link = usual;
  app.add_option("--link", args.link, "between server and viewer")
      ->type_name(text("NAME"))
      ->check(oneOf({"fixed", "wifi", "lte", "starlink", "geo", "trace"}))
      ->capture_default_str();
  app.add_option("--trace-up", args.trace_up, "mahimahi trace of the link `trace`, to the server")
      ->type_name(file("FILE"));
  app.add_option("--trace-down", args.trace_down, "mahimahi trace of the link `trace`, to the viewer")
      ->type_name(file("FILE"));
}

Result<sim::LinkPair> linksOf(const LinkArguments& args) {
  const bool is_recorded = args.link == "trace";
  if (is_recorded == args.trace_up.empty() || is_recorded == args.trace_down.empty())
    return Error{ErrorCode::kInvalidArgument,
                 "a recorded link takes --link trace, --trace-up FILE and --trace-down FILE"};
  if (is_recorded) return recordedLink(args.trace_up, args.trace_down);
  const auto model = sim::linkNamed(args.link);
  if (!model) return model.error();
  return model->links();
}

Result<sim::LinkPair> recordedLink(const std::filesystem::path& up, const std::filesystem::path& down) {
  const auto there = sim::LinkTrace::read(up), back = sim::LinkTrace::read(down);
  if (!there) return there.error();
  if (!back) return back.error();
  sim::LinkPair pair = sim::fixedLink(Duration::milliseconds(40));
  pair.up.trace = std::make_shared<sim::LinkTrace>(*there);
  pair.down.trace = std::make_shared<sim::LinkTrace>(*back);
  return pair;
}

void addRecordings(const sim::LinkPair& links, Fnv1a& hash) {
  for (const sim::LinkOptions* link : {&links.up, &links.down})
    for (size_t packets = 1; link->trace && packets < 4096; packets *= 2) {
      sim::LinkTrace::Position at;
      hash.addWord(
          std::bit_cast<uint64_t>(link->trace->transmit(packets * sim::LinkTrace::kPacketBytes, {}, at).toSeconds()));
    }
}

}  // namespace foreland::apps
