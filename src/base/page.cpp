#include "base/page.h"

#include <map>

#include "base/printable.h"

namespace slipstream {
namespace {

constexpr std::string_view style = R"(
:root { color-scheme: light dark; }
body { max-width: 62rem; margin: 2rem auto; padding: 0 1rem; font: 15px/1.5 system-ui, sans-serif; }
h1 { font-size: 1.5rem; } h2 { font-size: 1.1rem; margin-top: 2rem; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; }
th, td { padding: .25rem .7rem; border-bottom: 1px solid #8886; text-align: left;
         vertical-align: top; overflow-wrap: break-word; }
td:first-child, .facts td { overflow-wrap: anywhere; min-width: 4rem; }
figure { display: inline-block; margin: .5rem 1rem .5rem 0; break-inside: avoid; }
img { max-width: 100%; } figcaption { font-size: .85rem; opacity: .75; }
.verdict { padding: .6rem 1rem; border-left: .4rem solid; }
.good { border-color: #2e9e4f; } .usable { border-color: #d9930d; } .bad { border-color: #cf3a2e; }
.facts th { font-weight: normal; opacity: .75; white-space: nowrap; }
.signature { margin-top: 4rem; } .signature span { display: inline-block; width: 45%;
             margin-right: 4%; border-top: 1px solid; padding-top: .3rem; }
@page { margin: 15mm; }
@media print {
  :root { color-scheme: light; }
  body { margin: 0; padding: 0; max-width: none; font-size: 10pt; }
  table { width: 100%; font-size: 8.5pt; } th, td { padding: .15rem .35rem; }
  .facts { width: auto; } figure { width: 46%; margin: .3rem .5rem .3rem 0; }
  h2 { break-after: avoid; } tr, .verdict, .signature { break-inside: avoid; }
}
)";

}  // namespace

std::string escaped(std::string_view text) {
  static const std::map<char, std::string> entities{
      {'&', "&amp;"}, {'<', "&lt;"}, {'>', "&gt;"}, {'"', "&quot;"}};

  std::string safe;
  for (const char letter : printable_lines(text)) {
    const auto entity = entities.find(letter);
    safe += entity == entities.end() ? std::string(1, letter) : entity->second;
  }

  return safe;
}

Page::Page(std::string_view title, Wording wording)
    : wording_(wording),
      text_(fmt::format("<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<meta "
                        "name=\"viewport\" content=\"width=device-width\">\n<title>{0}</title>\n"
                        "<style>{1}</style>\n<h1>{0}</h1>\n",
                        escaped(title), style)) {}

void Page::verdict(const Verdict& verdict) {
  end_table();
  text_ += fmt::format("<p class=\"verdict {}\">{}</p>\n", verdict.grade, shown(verdict.words));
}

void Page::table(const std::vector<std::string>& columns) {
  end_table();
  // A head is repeated on each printed sheet.
  text_ += "<table>\n<thead>\n";
  in_table_ = true;
  cells_in("th", columns);
  text_ += "</thead>\n<tbody>\n";
}

void Page::facts(const Facts& facts) {
  end_table();
  text_ += "<table class=\"facts\">\n<tbody>\n";
  for (const auto& [name, value] : facts) {
    text_ +=
        fmt::format("<tr><th scope=\"row\">{}</th><td>{}</td></tr>\n", escaped(name), shown(value));
  }
  text_ += table_end;
}

void Page::signature() {
  end_table();
  text_ +=
      "<p class=\"signature\"><span>Date and place</span><span>Name and signature</span></p>\n";
}

void Page::picture(std::string_view says, const std::string& file) {
  end_table();
  text_ +=
      fmt::format("<figure><img alt=\"{0}\" src=\"{1}\"><figcaption>{0}</figcaption></figure>\n",
                  escaped(says), escaped(file));
  files_.push_back(file);
}

void Page::add(std::string_view element, std::string_view text) {
  end_table();
  text_ += fmt::format("<{0}>{1}</{0}>\n", element, shown(text));
}

void Page::cells_in(std::string_view element, const std::vector<std::string>& cells) {
  text_ += "<tr>";
  for (const std::string& cell : cells) {
    text_ += fmt::format("<{0}>{1}</{0}>", element, shown(cell));
  }
  text_ += "</tr>\n";
}

}  // namespace slipstream
