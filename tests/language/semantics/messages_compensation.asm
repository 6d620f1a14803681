// handlers are rules: an exception runs its own, compensation those of all activities, one after the other
asm messages_compensation
import StandardLibrary
import CommonBehavior
signature:
  domain Peer subsetof Agent
  static a: Peer
  controlled undone: String -> Boolean
  controlled handled: Boolean
  controlled round: Integer
definitions:
  rule r_handle($a in Agent) = handled := true
  rule r_unload($a in Agent) = undone("load") := true
  rule r_unbook($a in Agent) = undone("book") := true
  main rule r_Main =
    par
      round := round + 1
      if round = 0 then
        par
          exceptionHandler(a, "stuck") := <<r_handle>>
          compensationHandler(a, "load") := <<r_unload>>
          compensationHandler(a, "book") := <<r_unbook>>
          toCompensate(a, "trip") := ["load", "book"]
        endpar
      endif
      if round = 1 then r_raiseException[a, "stuck", "wheel"] endif
      if round = 2 then r_compensateAll[a, "trip"] endif
    endpar
default init s0:
  function round = 0
//= step 1: compensationHandler(a,"book") := rule r_unbook(Agent), compensationHandler(a,"load") := rule r_unload(Agent), exceptionHandler(a,"stuck") := rule r_handle(Agent), round := 1, toCompensate(a,"trip") := ["load","book"]
//= step 2: exceptionSubject(a) := "wheel", handled := true, round := 2, status(a) := EXCEPTION
//= step 3: round := 3, status(a) := COMPENSATION, toCompensate(a,"trip") := [], undone("book") := true, undone("load") := true
