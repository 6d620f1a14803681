asm misfits_operation
import StandardLibrary
import CommonBehavior
signature:
  domain Planner subsetof Agent
  static planner: Planner
  out plan: Prod(Agent, Integer, Integer) -> Integer
  controlled path: String
definitions:
  main rule r_Main =
    par
      r_wsend[planner, "plan", "kitchen"]  //~ A041
      r_wcall[planner, "plan", (3, 4), 500, path]  //~ A041
    endpar
