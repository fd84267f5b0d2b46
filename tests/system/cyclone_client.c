/* SPDX-License-Identifier: Apache-2.0
 * A client of the daemon on another vendor's DDS, from the same IDL: the oracle of our wire.
 * usage: cyclone_client DOMAIN CELL TASK [cancel|dispose]
 * Waits for a daemon that is ready, sends a request, prints a line per event, ends at the outcome.
 * At the second event it cancels or disposes its request, if asked. */
#include "dds/dds.h"
#include "handover.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void check(dds_return_t code, const char* what) {
  if (code >= 0) return;
  fprintf(stderr, "%s: %s\n", what, dds_strretcode(-code));
  exit(4);
}

static dds_entity_t must(dds_entity_t entity, const char* what) {
  check(entity, what);
  return entity;
}

static dds_qos_t* reliable(int keep_all) {
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  dds_qset_durability(qos, DDS_DURABILITY_TRANSIENT_LOCAL);
  dds_qset_history(qos, keep_all ? DDS_HISTORY_KEEP_ALL : DDS_HISTORY_KEEP_LAST, 1);
  return qos;
}

/* Takes one valid sample into *sample (loaned to the type's memory); waits up to 20 s. */
static int take(dds_entity_t reader, void* sample) {
  dds_entity_t participant = dds_get_participant(reader);
  dds_entity_t wait = must(dds_create_waitset(participant), "waitset");
  dds_entity_t condition = must(dds_create_readcondition(reader, DDS_ANY_STATE), "condition");
  check(dds_waitset_attach(wait, condition, 0), "attach");
  int got = 0;
  while (!got) {
    dds_sample_info_t info;
    dds_return_t n = dds_take(reader, &sample, &info, 1, 1);
    check(n, "take");
    if (n == 1 && info.valid_data) got = 1;
    if (n == 0 && dds_waitset_wait(wait, NULL, 0, DDS_SECS(20)) <= 0) break;
  }
  dds_delete(wait);
  dds_delete(condition);
  return got;
}

/* Matched first: a cancel is not kept for those who come later. */
static void sendCancel(dds_entity_t participant, const uint8_t* id) {
  dds_entity_t topic = must(dds_create_topic(participant, &handover_msg_HandoverCancel_desc,
                                             "handover/v1/cancel", NULL, NULL),
                            "topic");
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  dds_entity_t writer = must(dds_create_writer(participant, topic, qos, NULL), "cancel writer");
  check(dds_set_status_mask(writer, DDS_PUBLICATION_MATCHED_STATUS), "mask");
  dds_entity_t wait = must(dds_create_waitset(participant), "waitset");
  check(dds_waitset_attach(wait, writer, 0), "attach");
  if (dds_waitset_wait(wait, NULL, 0, DDS_SECS(20)) <= 0) exit(13);
  handover_msg_HandoverCancel cancel = {0};
  cancel.version = handover_msg_WIRE_VERSION;
  memcpy(cancel.request_id, id, 16);
  check(dds_write(writer, &cancel), "write");
}

int main(int argc, char** argv) {
  if (argc < 4) return 2;
  dds_entity_t participant =
      must(dds_create_participant((dds_domainid_t)atoi(argv[1]), NULL, NULL), "participant");
  dds_entity_t status_topic = must(dds_create_topic(participant, &handover_msg_DaemonStatus_desc,
                                                    "handover/v1/status", NULL, NULL),
                                   "topic");
  dds_entity_t event_topic = must(
      dds_create_topic(participant, &handover_msg_PlanEvent_desc, "handover/v1/event", NULL, NULL),
      "topic");
  dds_entity_t request_topic =
      must(dds_create_topic(participant, &handover_msg_HandoverRequest_desc, "handover/v1/request",
                            NULL, NULL),
           "topic");

  dds_qos_t* last = reliable(0);
  dds_qos_t* all = reliable(1);
  const char* partition = "cyclone";
  dds_qset_partition(all, 1, &partition);
  dds_entity_t subscriber = must(dds_create_subscriber(participant, all, NULL), "subscriber");
  dds_entity_t statuses =
      must(dds_create_reader(participant, status_topic, last, NULL), "status reader");
  dds_entity_t events = must(dds_create_reader(subscriber, event_topic, all, NULL), "event reader");
  dds_entity_t requests =
      must(dds_create_writer(participant, request_topic, last, NULL), "request writer");

  static handover_msg_DaemonStatus status;
  do {
    if (!take(statuses, &status)) return 13;
  } while (status.state == handover_msg_DAEMON_PREPARING);
  printf("status version %u state %d cell %s revision %llu\n", status.version, (int)status.state,
         status.cells._buffer[0].name, (unsigned long long)status.cells._buffer[0].scene_revision);

  static handover_msg_HandoverRequest request;
  request.version = handover_msg_WIRE_VERSION;
  for (int i = 0; i < 16; ++i)
    request.request_id[i] = (uint8_t)(i + 1 + (argc > 4 ? argv[4][0] : 0));
  char empty[] = "";
  request.client_id = "cyclone";
  request.cell = argv[2];
  request.task = argv[3];
  request.object_name = request.expected_hash = empty;
  request.X_WO_goal.orientation.w = 1;
  request.seed = 1;
  request.speed_scale = 1;
  request.slack_s = 0.25;
  check(dds_write(requests, &request), "write");

  while (1) {
    static handover_msg_PlanEvent event;
    if (!take(events, &event)) return 1;
    /* Earlier answers to this client id are kept for a while. */
    if (memcmp(event.request_id, request.request_id, 16) != 0) continue;
    printf("event %u payload %d", event.sequence_number, (int)event.payload._d);
    if (event.payload._d == handover_msg_PAYLOAD_SCENE) {
      const handover_msg_SceneSnapshot* scene = &event.payload._u.scene_value;
      printf(" robot %s q %.17g part %.17g end %d", scene->robots._buffer[0].name,
             scene->robots._buffer[0].q_start._buffer[1].position,
             scene->objects._buffer[1].shape.parts._buffer[0].radius, (int)scene->end);
    }
    if (event.payload._d == handover_msg_PAYLOAD_SOLUTION) {
      const handover_msg_Solution* solution = &event.payload._u.solution_value;
      printf(" holders %u stages %u cost %.17g bound %.17g", solution->holders._length,
             solution->stage_count, solution->cost, solution->quality.bound_s);
    }
    if (event.payload._d == handover_msg_PAYLOAD_TRAJECTORY) {
      const handover_msg_StageTrajectory* stage = &event.payload._u.trajectory_value;
      printf(" holder %u action %d", stage->holder, (int)stage->action);
      if (stage->qdd._length > 2) {
        printf(" qdd %.17g of %u", stage->qdd._buffer[2], stage->qdd._length);
      }
    }
    if (event.payload._d == handover_msg_PAYLOAD_FAILURE) {
      const handover_msg_Failure* failure = &event.payload._u.failure_value;
      printf(" reason %d causes %u", (int)failure->reason, failure->why.causes._length);
    }
    if (event.payload._d == handover_msg_PAYLOAD_OUTCOME) {
      const handover_msg_Outcome* outcome = &event.payload._u.outcome_value;
      printf(" outcome %d cancelled by %d\n", (int)outcome->kind, (int)outcome->cancelled_by);
      break;
    }
    printf("\n");
    if (argc > 4 && event.sequence_number == 1) {
      if (strcmp(argv[4], "dispose") == 0) check(dds_dispose(requests, &request), "dispose");
      if (strcmp(argv[4], "cancel") == 0) sendCancel(participant, request.request_id);
    }
  }
  dds_delete(participant);
  return 0;
}
