// an agent that is blocked, failed or ended sends nothing; undef is not sent
asm messages_blocked
import StandardLibrary
import CommonBehavior
signature:
  domain Peer subsetof Agent
  static a: Peer
  controlled n: Integer
definitions:
  main rule r_Main =
    par
      r_wsend[a, "tell", 1]
      r_wsend[a, "tell", n]
      r_wsend[a, "ring"]
      switch status(self)
        case READY: status(self) := BLOCKED
        case BLOCKED: r_exit[self]
        otherwise status(self) := READY
      endswitch
    endpar
//= step 1: status(undef) := READY, undef -> a: tell(1), undef -> a: ring(true)
//= step 2: status(undef) := BLOCKED, undef -> a: tell(1), undef -> a: ring(true)
//= step 3: status(undef) := EXITED
//= step 4: status(undef) := READY
