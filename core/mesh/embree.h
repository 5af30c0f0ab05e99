/// Ray queries of Embree 3 (Debian 12) and Embree 4 (Debian 13) in one form.
#pragma once

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

namespace edge_mcl::embree {

#if RTC_VERSION_MAJOR >= 4

/// Flag of a scene whose queries may have a filter.
constexpr RTCSceneFlags kFilterFlag = RTC_SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS;

/// What a filter function gets as `context`. It can be the first member of a larger struct.
using QueryContext = RTCRayQueryContext;

/// Finds the first hit of a ray.
inline void intersect1(RTCScene scene, RTCRayHit* ray) { rtcIntersect1(scene, ray, nullptr); }

/// Finds the first hits of 16 rays that lie side by side.
inline void intersect16(const int* valid, RTCScene scene, RTCRayHit16* rays) {
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
  rtcIntersect16(valid, scene, rays, &arguments);
}

/// Finds out whether something is on a ray; its tfar is negative then.
inline void occluded1(RTCScene scene, RTCRay* ray) { rtcOccluded1(scene, ray, nullptr); }

/// The same, with a filter that sees every hit and may refuse it.
inline void occluded1(RTCScene scene, RTCRay* ray, QueryContext* context,
                      RTCFilterFunctionN filter) {
  rtcInitRayQueryContext(context);
  RTCOccludedArguments arguments;
  rtcInitOccludedArguments(&arguments);
  arguments.flags = RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER;
  arguments.context = context;
  arguments.filter = filter;
  rtcOccluded1(scene, ray, &arguments);
}

/// The same for 16 rays that lie side by side.
inline void occluded16(const int* valid, RTCScene scene, RTCRay16* rays) {
  RTCOccludedArguments arguments;
  rtcInitOccludedArguments(&arguments);
  arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
  rtcOccluded16(valid, scene, rays, &arguments);
}

#else

constexpr RTCSceneFlags kFilterFlag = RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION;

using QueryContext = RTCIntersectContext;

inline void intersect1(RTCScene scene, RTCRayHit* ray) {
  QueryContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(scene, &context, ray);
}

inline void intersect16(const int* valid, RTCScene scene, RTCRayHit16* rays) {
  QueryContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  rtcIntersect16(valid, scene, &context, rays);
}

inline void occluded1(RTCScene scene, RTCRay* ray) {
  QueryContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(scene, &context, ray);
}

inline void occluded1(RTCScene scene, RTCRay* ray, QueryContext* context,
                      RTCFilterFunctionN filter) {
  rtcInitIntersectContext(context);
  context->filter = filter;
  rtcOccluded1(scene, context, ray);
}

inline void occluded16(const int* valid, RTCScene scene, RTCRay16* rays) {
  QueryContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  rtcOccluded16(valid, scene, &context, rays);
}

#endif

}  // namespace edge_mcl::embree
