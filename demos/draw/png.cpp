// Draws the primitives with Cairo onto an image in memory.
#include "draw/png.h"

#include <cairo.h>

#include <cmath>
#include <memory>
#include <numbers>

#include "io/errors.h"
#include "io/text.h"

namespace cloudcontact::program {

namespace {

struct Release {
  void operator()(cairo_t* context) const { cairo_destroy(context); }
  void operator()(cairo_surface_t* surface) const { cairo_surface_destroy(surface); }
};

void setColor(cairo_t* context, const Color& c) {
  cairo_set_source_rgba(context, c.red / 255.0, c.green / 255.0, c.blue / 255.0, c.alpha);
}

void setRectangle(cairo_t* context, const Rectangle& r) {
  cairo_rectangle(context, r.low.x(), r.low.y(), r.size().x(), r.size().y());
}

struct Painter {
  cairo_t* context;

  // Fills and outlines the current path.
  void paint(const Paint& paint) const {
    if (paint.fill) {
      setColor(context, *paint.fill);
      cairo_fill_preserve(context);
    }
    if (paint.stroke) {
      setColor(context, *paint.stroke);
      cairo_set_line_width(context, paint.width);
      cairo_stroke_preserve(context);
    }
    cairo_new_path(context);
  }
  void operator()(const Polygons& p) const {
    for (const auto& ring : p.rings) {
      cairo_new_sub_path(context);
      for (const Point& point : ring) cairo_line_to(context, point.x(), point.y());
      if (p.closed) cairo_close_path(context);
    }
    paint(p.paint);
  }
  void operator()(const Circle& c) const {
    cairo_arc(context, c.center.x(), c.center.y(), c.radius, 0, 2 * std::numbers::pi);
    cairo_close_path(context);
    paint(c.paint);
  }
  void operator()(const Text& t) const {
    const std::string words = printable(t.words);
    cairo_select_font_face(context, kFontFamily, CAIRO_FONT_SLANT_NORMAL,
                           t.bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
    cairo_set_font_size(context, t.size);
    cairo_text_extents_t extents;
    cairo_text_extents(context, words.c_str(), &extents);
    const double share = t.align == Align::Left ? 0 : t.align == Align::Middle ? 0.5 : 1;
    cairo_move_to(context, t.at.x() - share * extents.x_advance, t.at.y());
    cairo_text_path(context, words.c_str());
    if (t.halo) {
      setColor(context, {255, 255, 255});
      cairo_set_line_width(context, t.size / 4);
      cairo_stroke_preserve(context);
    }
    paint({t.color, std::nullopt, 0});
  }
  void operator()(const GroupBegin& g) const {
    cairo_save(context);
    if (!g.clip) return;
    setRectangle(context, *g.clip);
    cairo_clip(context);
  }
  void operator()(const GroupEnd&) const { cairo_restore(context); }
};

void check(cairo_status_t status) {
  if (status != CAIRO_STATUS_SUCCESS)
    throw WorkFailed(std::string("the picture could not be drawn: ") +
                     cairo_status_to_string(status));
}

cairo_status_t append(void* bytes, const unsigned char* data, unsigned int length) {
  static_cast<std::string*>(bytes)->append(reinterpret_cast<const char*>(data), length);
  return CAIRO_STATUS_SUCCESS;
}

}  // namespace

std::string pngBytes(const Drawing& drawing) {
  const auto pixels = [](double px) { return static_cast<int>(std::ceil(px * kPixelsPerPx)); };
  // Opaque, because a transparent picture is unreadable on a dark page.
  const std::unique_ptr<cairo_surface_t, Release> surface(cairo_image_surface_create(
      CAIRO_FORMAT_RGB24, pixels(drawing.width), pixels(drawing.height)));
  const std::unique_ptr<cairo_t, Release> context(cairo_create(surface.get()));
  cairo_scale(context.get(), kPixelsPerPx, kPixelsPerPx);
  cairo_set_line_join(context.get(), CAIRO_LINE_JOIN_ROUND);
  cairo_set_line_cap(context.get(), CAIRO_LINE_CAP_ROUND);
  setColor(context.get(), {255, 255, 255});
  cairo_paint(context.get());
  const Painter painter{context.get()};
  for (const DrawingItem& item : drawing.items) std::visit(painter, item);
  check(cairo_status(context.get()));
  std::string bytes;
  check(cairo_surface_write_to_png_stream(surface.get(), append, &bytes));
  return bytes;
}

}  // namespace cloudcontact::program
