// SPDX-License-Identifier: Apache-2.0
#include "view/page_templates.hpp"

extern const char kViewerPage[], kViewerPageEnd[], kReportPage[], kReportPageEnd[];
asm(".section .rodata\n"
    ".global kViewerPage, kViewerPageEnd, kReportPage, kReportPageEnd\n"
    "kViewerPage: .incbin \"" HANDOVER_PAGES
    "/viewer.html\"\n"
    "kViewerPageEnd: .byte 0\n"
    "kReportPage: .incbin \"" HANDOVER_PAGES
    "/report.html\"\n"
    "kReportPageEnd: .byte 0\n"
    ".previous\n");

namespace handover::view {
namespace {

std::string_view between(const char* begin, const char* end) {
  return {begin, static_cast<std::size_t>(end - begin)};
}

}  // namespace

std::optional<PageTemplates> pageTemplates() {
  return PageTemplates{between(kViewerPage, kViewerPageEnd), between(kReportPage, kReportPageEnd)};
}

}  // namespace handover::view
