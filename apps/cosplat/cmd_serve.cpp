// cosplat serve: a model's page, on this machine only.
#include <httplib.h>

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "apps/cosplat/commands.h"
#include "apps/cosplat/play_content.h"
#include "apps/cosplat/run/relay.h"
#include "apps/cosplat/run/web_model.h"
#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/json.h"
#include "splat/base/process.h"
#include "splat/base/text.h"

namespace cosplat {
namespace {

namespace fs = std::filesystem;

struct ServeOptions {
  std::string model, flame, relay, page = "gallery";
  int port = 8080;
  bool stay = false;
};

// What the page asks for first. The files have fixed names, but their own extensions.
Json Description(const WebModel& model) {
  const auto url = [](const char* name, const std::string& path) {
    return std::string("/model/") + name + fs::path(path).extension().string();
  };
  Json json{{"title", model.title}};
  if (model.avatar.empty()) {
    json["splats"] = url("splats", model.splats);
  } else {
    json["avatar"] = url("avatar", model.avatar);
    if (!model.flame.empty()) json["flame"] = url("flame", model.flame);
  }
  return json;
}

// Answers GETs of `url` with the file as it is at that time.
void ServeFile(httplib::Server& server, const std::string& url, const std::string& path) {
  server.Get(url, [path](const httplib::Request&, httplib::Response& out) {
    try {
      const std::vector<char> bytes = ReadFile(path);
      out.set_content(bytes.data(), bytes.size(), "application/octet-stream");
    } catch (const Error&) {
      out.status = 404;
    }
  });
}

constexpr const char *kRelayUrl = "/drive", *kStudio = "studio";

// Of avatars; null without --relay.
std::unique_ptr<Relay> OpenRelay(const ServeOptions& o) {
  if (o.relay.empty()) return nullptr;
  if (!IsLiveDrive(o.relay))
    throw Error("--relay", "is for live drives; '" + o.relay + "' is a recording");
  const viewer::Content content = LoadContent(o.model, o.flame);
  if (!content.avatar) throw Error(o.model, "--relay", "is for avatars; this is a scene");
  const viewer::Content::Avatar& avatar = *content.avatar;
  LiveSourceOptions options;
  options.flame = &avatar.flame;
  if (avatar.model.blendshapes) options.blendshapes = &*avatar.model.blendshapes;
  options.program = ThisProgram();
  return std::make_unique<Relay>(OpenLiveSource(o.relay, options),
                                 size_t(avatar.flame.expression_count));
}

// Server-sent events; a comment where no frame comes, so that a reader that has gone is noticed.
void ServeRelay(httplib::Server& server, Relay& relay) {
  constexpr std::chrono::milliseconds kPatience{1000};
  server.Get(kRelayUrl, [&relay](const httplib::Request&, httplib::Response& out) {
    out.set_chunked_content_provider(
        "text/event-stream", [&relay, seen = uint64_t(0)](size_t, httplib::DataSink& sink) mutable {
          const std::string line = relay.Next(seen, kPatience);
          const std::string event = line.empty() ? ":\n\n" : "data: " + line + "\n\n";
          return sink.write(event.data(), event.size());
        });
  });
}

void OpenInBrowser(const std::string& url) {
  const std::string program = FindProgram("xdg-open");
  if (!program.empty()) RunProcess({program, url}, {}, [](const std::string&) {});
}

// The pages, and what they load.
void ServePages(httplib::Server& server, const std::string& folder) {
  // What allows a page to share memory between threads.
  server.set_default_headers({{"Cross-Origin-Opener-Policy", "same-origin"},
                              {"Cross-Origin-Embedder-Policy", "require-corp"},
                              {"Cache-Control", "no-cache"}});
  for (const char* part : {"dist", "pages", "src"})
    if (!server.set_mount_point(std::string("/") + part, folder + "/" + part))
      throw Error(folder + "/" + part, "is missing");
  for (const auto& [extension, type] : {std::pair("mjs", "text/javascript"),
                                        std::pair("js", "text/javascript"),
                                        std::pair("wasm", "application/wasm")})
    server.set_file_extension_and_mimetype_mapping(extension, type);
  server.Get("/service-worker.js", [folder](const httplib::Request&, httplib::Response& out) {
    const std::vector<char> bytes = ReadFile(folder + "/service-worker.js");
    out.set_content(bytes.data(), bytes.size(), "text/javascript");
  });
}

void ServeModel(httplib::Server& server, const WebModel& model, const Relay* relay) {
  Json description = Description(model);
  if (relay) description["drive"] = std::string("events:") + kRelayUrl;
  server.Get("/model.json", [description](const httplib::Request&, httplib::Response& out) {
    out.set_content(description.dump(), "application/json");
  });
  for (const auto& [field, path] : {std::pair("avatar", model.avatar),
                                    std::pair("flame", model.flame),
                                    std::pair("splats", model.splats)})
    if (!path.empty()) ServeFile(server, description[field], path);
}

void Serve(const ServeOptions& o) {
  const bool makes = o.page == kStudio;
  if (makes && (!o.model.empty() || !o.flame.empty() || !o.relay.empty()))
    throw Error("--page studio", "makes an avatar, and takes no model, --flame or --relay");
  if (!makes && o.model.empty()) throw Error("model", "is missing; only --page studio has none");
  std::optional<WebModel> model;
  if (!makes) model = FindWebModel(o.model, o.flame);
  httplib::Server server;
  ServePages(server, WebFolder(makes ? "dist/trainer.wasm" : "dist/player.wasm"));
  const std::unique_ptr<Relay> relay = OpenRelay(o);
  if (relay) ServeRelay(server, *relay);
  if (model) ServeModel(server, *model, relay.get());
  const int port = o.port == 0 ? server.bind_to_any_port("127.0.0.1")
                               : (server.bind_to_port("127.0.0.1", o.port) ? o.port : -1);
  if (port < 0) throw Error("--port", Format("{} is in use; --port 0 takes a free one", o.port));
  const std::string name = o.page == "gallery" ? "index" : o.page;
  const std::string url = "http://127.0.0.1:" + std::to_string(port) + "/pages/" + name + ".html";
  std::printf("%s\nCtrl-C ends it.\n", url.c_str());
  std::fflush(stdout);
  if (!o.stay) OpenInBrowser(url);
  server.listen_after_bind();
}

}  // namespace

void AddServe(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "serve", "show a model in the browser, or make one there, from a server on this machine");
  const auto o = std::make_shared<ServeOptions>();
  command->add_option(
      "model", o->model, "a run's folder, an avatar (.glb) or splats (.ply, .splat, .spz, .sog)");
  command->add_option("--flame", o->flame, "FLAME model file; the one trained with if not given");
  command->add_option("--page", o->page, "the page to open; studio: film yourself, without a model")
      ->check(CLI::IsMember({"gallery", "obs", "webcam", kStudio}));
  command->add_option(
      "--relay", o->relay, "a live drive, as of play, for pages, which have no UDP: vts://PHONE");
  command->add_option("--port", o->port, "0: a free one")->check(CLI::Range(0, 65535));
  command->add_flag("--no-open", o->stay, "only print the address");
  command->callback([o] { Serve(*o); });
}

}  // namespace cosplat
