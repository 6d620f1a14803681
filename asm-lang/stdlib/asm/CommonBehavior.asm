// Messages between agents, and between a specification and the services around it (SCA-ASM).
//
//     r_wsend[planner, "plan", goal]                          // send without waiting
//     r_wreceive[client(self), "r_drive(Agent,Goal)", goal]   // receive the next message
//     r_wreply[client(self), "r_drive(Agent,Goal)", true]     // reply to it
//     r_wsendreceive[planner, "plan", goal, path]             // send, and poll until the reply arrives
//     r_wcall[planner, "plan", goal, 2000, path]              // the same, with a timeout of 2000 ms
//     r_wcancel[planner, "plan"]                              // stop waiting for the reply
//
// Messages wait outside the state: a step can send any number, and none overwrites another. A
// message arrives in the next step at the earliest. A step sees one message for each sender and
// operation, the oldest; a reply answers the request that was received longest ago.
module CommonBehavior

import StandardLibrary

export *

signature:
	domain CommunicationChannel subsetof Agent
	domain Clock subsetof Agent
	enum domain Status = {INIT | READY | BLOCKED | EXITED | EXCEPTION | COMPENSATION}
	enum domain CommunicatorStatus = {AVAILABLE | UNAVAILABLE | RESET}
	// reasons for the end of a call without a reply
	enum domain CallFault = {CALL_TIMEOUT | CALL_UNAVAILABLE | CALL_FAILED | CALL_CANCELLED}

	// state of an agent; a blocked one waits for a message and sends none
	controlled status: Agent -> Status
	// the channel for all messages, and the clock
	static communicator: CommunicationChannel
	static clock: Clock
	// state of the channel: that of the broker
	monitored communicatorStatus: CommunicationChannel -> CommunicatorStatus
	// time in milliseconds
	monitored time: Clock -> Integer

	// operation of the oldest message that an agent has not received
	monitored nextRequest: Agent -> String
	// arrived(a, b, op): data of the oldest message from b to a with this operation
	monitored arrived: Prod(Agent, Agent, String) -> Any
	// answered(a, b, op): reply to the oldest call from a to b
	monitored answered: Prod(Agent, Agent, String) -> Any
	// calling(a, b, op): true if a waits for a reply from b
	monitored calling: Prod(Agent, Agent, String) -> Boolean
	// reason for the failure of the last call of an operation, until the next call
	monitored callFault: Prod(Agent, String) -> CallFault
	// true if the last message with this operation could not be sent
	monitored sendFault: Prod(Agent, String) -> Boolean

	// handlers of exceptions and compensations of an agent, by name
	controlled exceptionHandler: Prod(Agent, String) -> Rule(Agent)
	controlled compensationHandler: Prod(Agent, String) -> Rule(Agent)
	controlled exceptionSubject: Agent -> String
	// activities of an agent that can be compensated, the last one first
	controlled toCompensate: Prod(Agent, String) -> Seq(String)

	// true if an agent can send: it has not ended, failed or blocked
	derived canSend: Agent -> Boolean

definitions:
	function canSend($a in Agent) =
		isUndef(status($a)) or status($a) = READY or status($a) = INIT

	// ---- implemented by the machine; the bodies are not used ---------------------------------

	macro rule r_actSend($self in Agent, $to in Agent, $operation in String, $data in Any) = skip
	macro rule r_actCall(
		$self in Agent,
		$to in Agent,
		$operation in String,
		$data in Any,
		$ms in Integer
	) =
		skip
	macro rule r_actReply($self in Agent, $to in Agent, $operation in String, $data in Any) = skip
	macro rule r_actTake($self in Agent, $from in Agent, $operation in String) = skip
	macro rule r_actAnswer($self in Agent, $from in Agent, $operation in String) = skip
	macro rule r_actWait($self in Agent) = skip
	macro rule r_actCancel($self in Agent, $to in Agent, $operation in String) = skip

	// ---- messages -----------------------------------------------------------------------------

	macro rule r_wsend($to in Agent, $operation in String, $data in Any) =
		if isDef($data) and canSend(self) then
			r_actSend[self, $to, $operation, $data]
		endif

	macro rule r_wsend($to in Agent, $operation in String) =
		if canSend(self) then
			r_actSend[self, $to, $operation, true]
		endif

	macro rule r_wreceive($from in Agent, $operation in String, $data in Any) =
		let ($message = arrived(self, $from, $operation)) in
			if isDef($message) then
				par
					$data := $message
					r_actTake[self, $from, $operation]
				endpar
			else
				r_actWait[self]
			endif
		endlet

	macro rule r_wreceive($from in Agent, $operation in String) =
		if isDef(arrived(self, $from, $operation)) then
			r_actTake[self, $from, $operation]
		else
			r_actWait[self]
		endif

	macro rule r_wreply($to in Agent, $operation in String, $data in Any) =
		if isDef($data) and canSend(self) then
			r_actReply[self, $to, $operation, $data]
		endif

	// spelling in older specifications
	macro rule r_wreplay($to in Agent, $operation in String, $data in Any) =
		r_wreply[$to, $operation, $data]

	// ---- calls --------------------------------------------------------------------------------

	macro rule r_poll($to in Agent, $operation in String, $reply in Any) =
		let ($answer = answered(self, $to, $operation)) in
			if isDef($answer) then
				par
					$reply := $answer
					r_actAnswer[self, $to, $operation]
				endpar
			endif
		endlet

	// calls only while the reply is undef: set it to undef to call again
	macro rule r_wcall(
		$to in Agent,
		$operation in String,
		$data in Any,
		$ms in Integer,
		$reply in Any
	) =
		if isUndef($reply) then
			if calling(self, $to, $operation) or isDef(answered(self, $to, $operation)) then
				r_poll[$to, $operation, $reply]
			else
				if isDef($data) and isUndef(callFault(self, $operation)) then
					r_actCall[self, $to, $operation, $data, $ms]
				endif
			endif
		endif

	macro rule r_wsendreceive($to in Agent, $operation in String, $data in Any, $reply in Any) =
		r_wcall[$to, $operation, $data, 0, $reply]

	macro rule r_wsendreceive($to in Agent, $operation in String, $reply in Any) =
		r_wcall[$to, $operation, true, 0, $reply]

	// discards the pending calls and the fault of the last one
	macro rule r_wcancel($to in Agent, $operation in String) =
		r_actCancel[self, $to, $operation]

	// ---- faults and compensation --------------------------------------------------------------

	macro rule r_raiseException($a in Agent, $handler in String, $subject in String) =
		par
			status($a) := EXCEPTION
			exceptionSubject($a) := $subject
			if isDef(exceptionHandler($a, $handler)) then
				exceptionHandler($a, $handler)[$a]
			endif
		endpar

	macro rule r_compensate($a in Agent, $handler in String) =
		par
			status($a) := COMPENSATION
			if isDef(compensationHandler($a, $handler)) then
				compensationHandler($a, $handler)[$a]
			endif
		endpar

	macro rule r_compensateAll($a in Agent, $activities in String) =
		while isDef(toCompensate($a, $activities)) and length(toCompensate($a, $activities)) > 0 do
			seq
				r_compensate[$a, first(toCompensate($a, $activities))]
				toCompensate($a, $activities) := tail(toCompensate($a, $activities))
			endseq

	macro rule r_exit($a in Agent) =
		status($a) := EXITED

	// ---- implemented by the machine; without effect ---------------------------------------------

	macro rule r_CommunicatorProgram = skip
	macro rule r_ClockProgram = skip
	macro rule r_init($channel in CommunicationChannel) = skip
