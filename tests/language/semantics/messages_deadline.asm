// a call that is not answered in time fails, until it is cancelled and made again
asm messages_deadline
import StandardLibrary
import CommonBehavior
signature:
  domain Planner subsetof Agent
  //@Reference
  shared planner: Agent -> Planner
  out plan: Prod(Agent, Integer) -> Integer
  controlled path: Integer
  controlled tries: Integer
definitions:
  main rule r_Main =
    par
      r_wcall[planner(self), "plan", 7, 100, path]
      if callFault(self, "plan") = CALL_TIMEOUT then
        par
          tries := tries + 1
          r_wcancel[planner(self), "plan"]
        endpar
      endif
    endpar
default init s0:
  function tries = 0
//= step 1: undef -> planner: call plan(7) until 100000000 ns
//? step 2: time 50000000
//= step 2: nothing
//? step 3: time 100000000
//= step 3: tries := 1, undef -> planner: cancel plan
//? step 4: time 150000000
//= step 4: undef -> planner: call plan(7) until 250000000 ns
